# SPDX-License-Identifier: Apache-2.0
"""Makes a chart: runs, figures, pictures, page."""
import json
import math
import shlex
import subprocess
import sys
import time

import evaluate
import images
import ladder
import machine
import page
import plan
import runs


def _version(render):
    return subprocess.run([str(render), "--version"], capture_output=True, text=True, check=False).stdout.strip()


def _common_arguments(options):
    arguments = ladder.parse_options(options.common)
    if options.width:
        arguments += ["--size", f"{options.width}x{options.height}"]
    if options.window:
        arguments += ["--window", options.window]
    if options.threads:
        arguments += ["--threads", str(options.threads)]
    return arguments


def _without_infinities(value):
    """JSON has none: they become null."""
    if isinstance(value, dict):
        return {key: _without_infinities(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_without_infinities(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _loads(records):
    every = [run["load"] for rungs in records["methods"].values() for rung in rungs for run in rung]
    return {"least": min(every), "most": max(every)}


def _parameters(options):
    names = ("methods", "budget", "rungs", "seeds", "reference_noise", "reference_batches", "reference_budget",
             "reference_spp", "width", "height", "window", "common", "threads", "clock", "metric", "ledger_spp")
    return {name: getattr(options, name) for name in names}


def _check_reference(context, methods, options):
    """Hours of rendering are no time to learn that the reference is unusable: the cheapest run tells."""
    record = runs.do(context, runs.make_job(methods[0], ladder.settings(methods[0]["method"], 0), 1))
    evaluate.require_same_size(images.read(options.reference), evaluate.load_image(options.output, record))


def make(options):
    """Does what is missing and writes all files into the folder of the options."""
    methods = ladder.parse_methods(options.methods)
    context = runs.make_context(options.render, options.scene, options.output, _common_arguments(options))
    runs.remove_unfinished(context)
    methods, refused = plan.applicable(context, methods, options.quiet)
    if options.reference:
        _check_reference(context, methods, options)
    records = plan.carry_out(context, methods, options)
    runs.remove_unfinished(context)
    figures, truth = evaluate.evaluate(options.output, methods, records, options)
    result = {
        "format": 1,
        "version": _version(options.render),
        "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "machine": machine.describe(),
        "load": _loads(records),
        "command": shlex.join(["manylight-chart", *sys.argv[1:]]),
        "scene": str(options.scene),
        "scene_name": options.scene.stem,
        "title": f"{options.scene.stem}, {figures['width']} x {figures['height']} pixels",
        "parameters": _parameters(options),
        **figures,
        "not_applicable": refused,
    }
    text = json.dumps(_without_infinities(result), indent=1) + "\n"
    runs.write_by_rename(options.output / "chart.json", text)
    runs.write_by_rename(options.output / "table.md", page.markdown(*page.cost_rows(result)))
    _draw(result, options.output, truth)
    runs.write_by_rename(options.output / "chart.html", page.render(result, options.output))


def _draw(result, folder, truth):
    import plots  # pylint: disable=import-outside-toplevel  # takes a second: not before bad input is told
    clock = result["parameters"]["clock"]
    for name, x_key, title in (("error_over_time", evaluate.CLOCKS[clock], f"{clock} time, s"),
                               ("error_over_rays", "rays", "rays")):
        for suffix in (".png", ".svg"):
            plots.save(plots.error_figure(result, x_key, title), folder / (name + suffix))
    plots.save(plots.contact_sheet(result, folder, truth), folder / "equal_time.png")
