# SPDX-License-Identifier: Apache-2.0
"""One table of many charts, for documents."""
import json
import math
import shlex

import evaluate
import page
import tables
from failure import InputError

TARGETS = (0.01, 0.003)  # relMSE
_LEAST_OVER_NOISE = 3.0  # a level below that many variances of the reference would be read off its noise
_LEAST_OF_NOISE = 0.1  # the variance itself is known to about a tenth


def load(folder):
    """[(name, chart)] of every chart.json below a folder, by name: that of the folder it lies in."""
    charts = []
    for path in sorted(folder.rglob("chart.json")):
        try:
            chart = json.loads(path.read_text())
            name = path.parent.relative_to(folder).as_posix() if path.parent != folder else chart["scene_name"]
            charts.append((name, chart))
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{path}: not a chart of manylight-chart") from error
    if not charts:
        raise InputError(f"{folder}: no chart.json in it or below")
    return charts


def _bias_squared(method):
    """(value, standard error), relative, at the dearest rung; None if the seeds are too few."""
    estimate = method["rungs"][-1].get("split", {}).get("rel_bias_squared")
    return None if not estimate or estimate["standard_error"] is None else tuple(estimate.values())


def time_cell(target, noise, times, errors, bias_squared):
    """Seconds until relMSE falls to the target, or to the level above the reference's noise that is told then.

    Where it does not: the bias^2 that keeps it above, if it is sure to; else how long it was tried.
    """
    level = max(target, _LEAST_OVER_NOISE * noise)
    seconds = tables.time_to(level, times, errors)
    if seconds == tables.FROM_THE_START:
        text = f"< {times[0]:.2g}"
    elif seconds != tables.NOT_REACHED:
        text = f"{seconds:.3g}"
    elif bias_squared and bias_squared[0] - 2 * bias_squared[1] > level:
        text = f"never, bias² {bias_squared[0]:.2g}"
    else:
        text = f"> {times[-1]:.3g}"
    return text if level == target else f"{text} (to {level:.2g})"


def _percent(estimate):
    return f"{100 * estimate['value']:.2f} ± {100 * estimate['standard_error']:.2f} %"


def _row(name, chart, method):
    times = [evaluate.medians(rung, evaluate.CLOCKS[chart["parameters"]["clock"]]) for rung in method["rungs"]]
    noise = chart["reference"]["rel_variance"] or 0.0
    found = [max(_median(rung) - noise, _LEAST_OF_NOISE * noise) for rung in method["rungs"]]
    bias_squared = _bias_squared(method)
    cells = [time_cell(target, noise, times, found, bias_squared) for target in TARGETS]
    bias = f"{bias_squared[0]:.2g} ± {bias_squared[1]:.1g}" if bias_squared else "-"
    missing = _percent(method["missing"]["against_reference"]) if method["missing"] else "-"
    return [name, method["label"], *cells, f"{times[-1]:.3g}", f"{found[-1]:.2g}", bias, missing]


def _median(rung):
    """Of relMSE; null in the file stands for infinity."""
    return tables.median([math.inf if run["rel_mse"] is None else run["rel_mse"] for run in rung["runs"]])


def rows(charts):
    """The table's head and its rows, one per scene and method."""
    head = ["scene", "method", *(f"s to relMSE {target:g}" for target in TARGETS), "longest, s", "relMSE there",
            "bias², relative, there", "missing light by ledger"]
    body = []
    for name, chart in charts:
        scene = f"{name} {chart['width']}x{chart['height']}"
        body += [_row(scene, chart, method) for method in chart["methods"]]
        for refused in chart.get("not_applicable", []):
            body.append([scene, refused["label"], f"not applicable: {refused['reason']}", *[""] * (len(head) - 3)])
    return head, body


def _reference(chart):
    noise = chart["reference"]["rel_variance"]
    if noise is None:
        return "reference from a file, whose noise counts as error and bias"
    source = " file, as given:" if "file" in chart["reference"] else ""
    return f"relative variance of the reference{source} {noise:.2g}"


def _command(chart):
    """What was called, without where the program and its files lie."""
    words, kept = iter(shlex.split(chart.get("command", ""))), []
    for word in words:
        if word in ("--render", "-o", "--output"):
            next(words, None)
        elif word not in ("-q", "--quiet") and not word.startswith(("--render=", "--output=")):
            kept.append(word)
    return f"`{shlex.join(kept)}`" if kept else "command not kept"


def _machine(chart):
    machine = chart["machine"]
    return f"{chart['version']}, {machine['processor']}, {machine['cores']} cores, {machine['system']}"


def markdown(charts):
    """The whole text."""
    machines = list(dict.fromkeys(_machine(chart) for _, chart in charts))
    where = f"Measured with {machines[0]}." if len(machines) == 1 else "Measured on several machines, named below."
    lines = []
    for name, chart in charts:
        of = "" if len(machines) == 1 else f"{_machine(chart)}; "
        parameters = chart["parameters"]
        lines.append(f"- {name}, {chart['date'][:10]}: {of}{parameters['seeds']} seeds, {parameters['clock']} seconds, "
                     f"load {chart['load']['least']:.1f} to {chart['load']['most']:.1f}; {_reference(chart)}; "
                     f"{_command(chart)}\n")
    return (f"{where} Medians over seeds. Seconds until relMSE falls to a level are read off in log-log between the "
            "points: `<` where the first is below it, `>` where the last is not; a level below "
            f"{_LEAST_OVER_NOISE:g} variances of the reference is raised to them. relMSE is without that variance, "
            "though never below a tenth of it; bias² is without it too.\n\n"
            + page.markdown(*rows(charts)) + "\n" + "".join(lines))
