#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What lightcuts and bidirectional lightcuts miss of every scene below a folder, as a Markdown table.

    benchmarks/methods/ledger_table.py PROGRAM FOLDER [more arguments of manylight-render]

PROGRAM is manylight-render. Scenes in folders named `include` or `fragments` are parts of others. A scene that the
program refuses is listed with its message. The table goes to the standard output, progress to the error stream.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

WIDTH = 160
METHODS = ("lightcuts", "bdlc")
ARGUMENTS = ["--vpls", "20000", "--eye-paths", "16", "--ledger-spp", "64"]
ENTRIES = {
    "clamp": "clamp",
    "diffuse_light": "diffuse light",
    "dirac": "dirac",
    "depth": "depth",
    "variance_after_clamp": "V after clamp",
    "variance_after_diffuse_light": "V after diffuse light",
    "variance_after_dirac": "V after dirac",
    "variance_first": "V first",
    "other": "other",
}


def render(program, scene, arguments, folder):
    """Statistics of a rendering; raises RuntimeError with the program's message."""
    stats = pathlib.Path(folder) / "stats.json"
    call = [program, str(scene), "-q", "-o", f"{folder}/image.pfm", "--stats", str(stats)] + arguments
    run = subprocess.run(call, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(run.stderr.strip() or f"exit code {run.returncode}")
    return json.loads(stats.read_text())


def percent(share):
    """Two significant digits, and a dash for nothing or what rounding makes of it."""
    if share < 1e-6:
        return "-"
    return f"{100 * share:.2g}" if share < 0.995 else "100"


def row(name, method, stats):
    """One line of the table."""
    missing = stats["missing"]
    truth = missing["truth"]["luminance"] or 1
    error = 100 * missing["total"]["standard_error"] / truth
    pixels = stats["width"] * stats["height"]
    cells = [name, method, f"{100 * missing['total']['share']:.2f} ± {error:.2f}"]
    cells += [percent(missing["entries"][key]["share"]) for key in ENTRIES]
    cells += [percent(stats["capped_pixels"] / pixels), f"{stats['cut']['mean']:.0f}"]
    return "| " + " | ".join(cells) + " |"


def main():
    """Renders every scene by every method."""
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, root = sys.argv[1], pathlib.Path(sys.argv[2])
    refused = []
    titles = ["scene", "method", "missing, %", *ENTRIES.values(), "capped pixels, %", "mean cut"]
    print("| " + " | ".join(titles) + " |")
    print("|---" * len(titles) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for scene in sorted(root.rglob("*.xml")):
            name = str(scene.relative_to(root))
            if {"include", "fragments"} & set(scene.relative_to(root).parts):
                continue
            print(name, file=sys.stderr, flush=True)
            try:
                probe = render(program, scene, ["-m", "path", "--spp", "1"], folder)
                size = f"{WIDTH}x{max(1, round(WIDTH * probe['height'] / probe['width']))}"
                for method in METHODS:
                    arguments = ["-m", method, "--size", size, *ARGUMENTS, *sys.argv[3:]]
                    print(row(name, method, render(program, scene, arguments, folder)), flush=True)
            except RuntimeError as error:
                message = str(error).replace(f"manylight-render: {scene}:", "line ")
                refused.append((name, message.replace(str(root), "...")))
    if refused:
        print("\nRefused:\n")
        for name, message in refused:
            print(f"- {name}: {message}")


if __name__ == "__main__":
    main()
