# SPDX-License-Identifier: Apache-2.0
"""What the figures were measured on."""
import os
import pathlib
import platform


def describe():
    """Processor, cores, system."""
    model = platform.processor() or platform.machine()
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    return {"processor": model, "cores": len(os.sched_getaffinity(0)),
            "system": f"{platform.system()} {platform.release()}"}
