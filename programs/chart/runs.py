# SPDX-License-Identifier: Apache-2.0
"""Runs of manylight-render. A finished run is two files, KEY.pfm and KEY.json; the latter comes last, by rename."""
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import time

from failure import InputError, NotApplicable

# How manylight-render says that a method does not do the scene; without the element of the file, in brackets.
_REFUSAL = re.compile(r"manylight-render: --method \S+ is for (.+?)(?: \('.*'\))?, allowed: .*")


def file_hash(path):
    """Tells apart scenes and programs that were changed in place."""
    try:
        return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error


def make_context(render, scene, folder, common):
    """What all runs share. `common` are arguments of all of them."""
    folder = pathlib.Path(folder)
    return {"render": str(render), "scene": str(scene), "folder": folder, "common": common,
            "identity": [file_hash(scene), file_hash(render), common]}


def make_job(method, settings, seed):
    """One run to do. Settings in the order in which files give them back: the names of runs hold them."""
    return {"label": method["label"], "method": method["method"], "arguments": method["arguments"],
            "settings": dict(sorted(settings.items())), "seed": seed}


def job_name(job):
    """For people."""
    settings = " ".join(f"{name} {value}" for name, value in job["settings"].items())
    return f"{job['label']} {settings} seed {job['seed']}"


def key_of(context, job):
    """Name of a run's files: readable, and different for different parameters, scenes and programs."""
    unique = json.dumps([context["identity"], job], sort_keys=True)
    words = "-".join([job["method"], *(str(value) for value in job["settings"].values()), f"s{job['seed']}"])
    return f"{words}-{hashlib.sha256(unique.encode()).hexdigest()[:12]}"


def path_of(context, job, suffix):
    """Where a run is kept; its folder is made."""
    folder = context["folder"] / "runs"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / (key_of(context, job) + suffix)


def find(context, job):
    """The record of a finished run, or None."""
    if not path_of(context, job, ".pfm").exists():
        return None
    try:
        return json.loads(path_of(context, job, ".json").read_text())
    except FileNotFoundError:
        return None


def write_by_rename(path, text):
    """Never leaves half a file."""
    part = path.with_name(path.name + ".part")
    part.write_text(text)
    os.replace(part, path)


def command_of(context, job, image, statistics):
    """The whole command line."""
    command = [context["render"], context["scene"], "--method", job["method"], "--seed", str(job["seed"])]
    for name, value in job["settings"].items():
        command += [f"--{name}", str(value)]
    return command + job["arguments"] + context["common"] + ["-q", "-o", str(image), "--stats", str(statistics)]


def refusal_reason(line):
    """What the scene has that the method cannot do, by the last line of a failed call; None if it failed otherwise."""
    refusal = _REFUSAL.fullmatch(line)
    return refusal[1] if refusal else None


def _call(command):
    """Seconds of all its threads. Raises InputError with its last line if it fails, NotApplicable if it refuses."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
        try:
            _, errors = child.communicate()
        except BaseException:
            child.kill()
            raise
    if child.returncode != 0:
        lines = errors.strip().splitlines() or [f"exit code {child.returncode}"]
        message = f"{lines[-1]} (in: {shlex.join(command)})"
        reason = refusal_reason(lines[-1])
        raise NotApplicable(message, reason) if reason else InputError(message)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def do(context, job):
    """The record of a run, which is done if it is not there yet."""
    record = find(context, job)
    if record:
        return record
    image = path_of(context, job, ".pfm")
    # Unfinished files lie apart, in a folder that the next start empties.
    scratch = context["folder"] / "unfinished"
    scratch.mkdir(parents=True, exist_ok=True)
    parts = scratch / image.name, scratch / "statistics.json"
    load = os.getloadavg()[0]
    start = time.time()
    cpu_seconds = _call(command_of(context, job, *parts))
    statistics = json.loads(parts[1].read_text())
    record = {
        **job,
        "image": f"runs/{image.name}",
        "command": shlex.join(command_of(context, job, image, image.with_suffix(".stats.json"))),
        "seconds": statistics["seconds"]["total"],
        "setup_seconds": statistics["seconds"]["load"] + statistics["seconds"]["build"],
        "cpu_seconds": cpu_seconds,
        "rays": sum(statistics["rays"].values()),
        "load": load,
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(start)),
        "statistics": statistics,
    }
    os.replace(parts[0], image)
    write_by_rename(image.with_suffix(".json"), json.dumps(record, indent=1, sort_keys=True) + "\n")
    return record


def remove_unfinished(context):
    """What a killed call left."""
    shutil.rmtree(context["folder"] / "unfinished", ignore_errors=True)
