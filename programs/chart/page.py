# SPDX-License-Identifier: Apache-2.0
"""One HTML page that holds all: no scripts, no other files."""
import base64
import html
import math

import evaluate
import tables

_STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: 0.2em 0.7em; border-bottom: 1px solid #ddd; text-align: right; }
th:first-child, td:first-child { text-align: left; }
img { max-width: 100%; }
code { font-size: 12px; word-break: break-all; }
.pair { display: flex; flex-wrap: wrap; } .pair img { width: 49%; }
"""


def _number(value, digits=3):
    return f"{value:.{digits}g}" if isinstance(value, (int, float)) else "-"


def _signed(estimate, unit=1.0, suffix=""):
    """A value with its standard error."""
    error = estimate["standard_error"]
    if not math.isfinite(error):
        return f"{unit * estimate['value']:+.2g}{suffix}"
    return f"{unit * estimate['value']:+.2g} ± {unit * error:.1g}{suffix}"


def _table(head, rows):
    cells = "".join(f"<th>{html.escape(text)}</th>" for text in head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f"<table><tr>{cells}</tr>\n{body}</table>\n"


def floor_text(floor):
    """The bias of a method's dearest rung."""
    if not floor:
        return "unknown"
    if floor["value"]:
        return f"bias {floor['value']:.2g}"
    return f"bias hidden, below {floor['below']:.2g}"


def time_rows(chart):
    """Cells of the table of time to reach an error, with its head."""
    labels = [method["label"] for method in chart["methods"]]
    floors = {method["label"]: floor_text(method["bias_floor"]) for method in chart["methods"]}
    table = chart["time_to_error"]
    rows = []
    for row in table["rows"]:
        cells = [_number(row["level"])]
        for label in labels:
            seconds = row["times"][label]
            text = f"{seconds:.3g} s" if isinstance(seconds, float) else seconds
            if seconds == tables.NOT_REACHED:
                text += f" ({floors[label]})"
            if label in row["speed_ups"] and label != table["base"]:
                text += f", {row['speed_ups'][label]:.2g} x"
            cells.append(text)
        rows.append(cells)
    return [evaluate.METRICS[chart["parameters"]["metric"]][2], *labels], rows


def summary_rows(chart):
    """One row per method at its dearest rung."""
    head = ["method", "settings", "seconds", "relMSE", "trimmed", "variance, relative", "bias², relative", "mean",
            "SSIM", "missing light", "slowest seed / fastest"]
    rows = []
    for method in chart["methods"]:
        rung = method["rungs"][-1]
        split, missing = rung.get("split"), method["missing"]
        seconds = [run[evaluate.CLOCKS[chart["parameters"]["clock"]]] for run in rung["runs"]]
        rows.append([
            method["label"], " ".join(f"{k} {v}" for k, v in rung["settings"].items()), _number(tables.median(seconds)),
            _number(evaluate.medians(rung, "rel_mse")), _number(evaluate.medians(rung, "trimmed_rel_mse")),
            _signed(split["rel_variance"]) if split else "-", _signed(split["rel_bias_squared"]) if split else "-",
            _signed(split["mean_signed_difference"], 100, " %") if split else "-",
            _number(evaluate.medians(rung, "ssim")) if "ssim" in rung["runs"][0] else "-",
            _signed(missing["against_reference"], 100, " %") if missing else "-",
            _number(max(seconds) / min(seconds), 2)])
    return head, rows


def cost_rows(chart):
    """One row per point; error times CPU seconds is nearly constant over the points of an unbiased method."""
    head = ["scene, size", "method", "CPU s", "relMSE", "trimmed", "mean", "trimmed x CPU"]
    rows = []
    for method in chart["methods"]:
        for rung in method["rungs"]:
            settings = ", ".join(f"{value} {name}" for name, value in rung["settings"].items())
            cpu, trimmed = (evaluate.medians(rung, key) for key in ("cpu_seconds", "trimmed_rel_mse"))
            rows.append([f"{chart['scene_name']} {chart['width']}x{chart['height']}", f"{method['label']}, {settings}",
                         f"{cpu:.1f}", f"{evaluate.medians(rung, 'rel_mse'):.4f}", f"{trimmed:.4f}",
                         f"{100 * evaluate.medians(rung, 'mean_signed_difference'):+.2f} %", f"{trimmed * cpu:.3f}"])
    for entry in chart["not_applicable"]:
        rows.append([rows[0][0], entry["label"], f"not applicable: {entry['reason']}", *[""] * (len(head) - 3)])
    return head, rows


def markdown(head, rows):
    """The same table in plain text."""
    return "".join("| " + " | ".join(row) + " |\n" for row in [head, ["---"] * len(head), *rows])


def reference_text(reference):
    """How good the reference is, in a sentence."""
    noise, share = reference["rel_variance"], reference["share_of_least_error"]
    if noise is None:
        return f"{reference['file']}, taken as exact: its own noise counts as error of the methods."
    if "file" in reference:
        text = f"{reference['file']}; relative variance, as given with --reference-noise, {noise:.2g}"
        split, advice = "relative bias² has it taken off, the absolute one has not.", ""
    else:
        text = (f"{reference['batches']} independent images by path, {reference['settings']['spp']} samples per pixel "
                f"each, with seeds of their own; relative variance of their mean {noise:.2g}")
        split = "the split into variance and bias² has it taken off."
        advice = " More than 1 %: a larger --reference-budget would make the lower ends more exact."
    if share is None:
        return text + "."
    return text + f", {100 * share:.2g} % of the least error charted; {split}" + ("" if share <= 0.01 else advice)


def not_applicable_text(chart):
    """The methods that do not do the scene, in a sentence each; nothing if all do."""
    return "".join(f"<p>Not applicable: {html.escape(entry['label'])}, {html.escape(entry['reason'])}.</p>\n"
                   for entry in chart["not_applicable"])


def _embed(path):
    kind = {".png": "image/png", ".svg": "image/svg+xml"}[path.suffix]
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def render(chart, folder):
    """The page's text; the pictures lie in `folder`."""
    machine, parameters = chart["machine"], chart["parameters"]
    commands = "".join(
        f"<li>{html.escape(m['label'])}: <code>{html.escape(m['rungs'][-1]['runs'][0]['command'])}</code></li>\n"
        for m in chart["methods"])
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(chart['title'])}</title><style>{_STYLE}</style></head>
<body>
<h1>{html.escape(chart['title'])}</h1>
<p>manylight {html.escape(chart['version'])}, {html.escape(chart['date'])}; {html.escape(machine['processor'])},
{machine['cores']} cores, {html.escape(machine['system'])}. {parameters['seeds']} seeds per point, {parameters['clock']}
seconds with loading and building. Lines are medians, bands reach from the best to the worst seed, dashed lines are the
bias of the dearest rung, dotted ones slopes of unbiased methods (-1/2) and of those whose bias shrinks with the cost
(-1/3). The machine's load average was {chart['load']['least']:.1f} to {chart['load']['most']:.1f}.</p>
<p>Reference: {html.escape(reference_text(chart['reference']))}</p>
{not_applicable_text(chart)}<div class="pair"><img alt="Error over time" src="{_embed(folder / 'error_over_time.svg')}">
<img alt="Error over rays" src="{_embed(folder / 'error_over_rays.svg')}"></div>
<h2>Time to reach an error</h2>
<p>By straight lines in log-log between the medians, never beyond them. Speed-ups are over
{html.escape(chart['time_to_error']['base'])}.</p>
{_table(*time_rows(chart))}
<h2>The dearest rung of each method</h2>
<p>MSE = variance + bias², both estimated without bias from all seeds: a bias² of nothing comes out negative as often as
not. Missing light is what the method's own ledger books as left out,
but for paths that are too long for the reference as well: it should be the mean with the other sign.</p>
{_table(*summary_rows(chart))}
<h2>Error times processor time</h2>
<p>Medians of all points. The product stays the same along the ladder of an unbiased method.</p>
{_table(*cost_rows(chart))}
<h2>At equal time</h2>
<img alt="Images at equal time" src="{_embed(folder / 'equal_time.png')}">
<h2>Commands</h2>
<ul>{commands}</ul>
<p>All others, and every figure, are in chart.json.</p>
</body></html>
"""
