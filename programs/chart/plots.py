# SPDX-License-Identifier: Apache-2.0
"""The pictures: error over time and over rays, and the contact sheet."""
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import errors
import evaluate
import images
import tables

DIFFERENCE_RANGE = 0.5  # relative difference in full colour
ZOOM = 16

plt.rcParams.update({"svg.hashsalt": "manylight", "svg.fonttype": "none", "font.size": 9})  # the same bytes each time


def colours(methods):
    """One colour per method, the same in every picture."""
    cycle = plt.get_cmap("tab10")
    return {method["label"]: cycle(i % 10) for i, method in enumerate(methods)}


def _guide(axes, slope, name, low, high, start):
    """A straight line of the given slope from (low, start)."""
    if high > low:
        axes.plot([low, high], [start, start * (high / low) ** slope], color="0.7", lw=0.8, ls=":", zorder=0)
        axes.annotate(name, (high, start * (high / low) ** slope), color="0.5", fontsize=7, ha="right", va="bottom")


def _draw_method(axes, method, x_key, metric, colour):
    key, exponent, _ = evaluate.METRICS[metric]
    xs = [evaluate.medians(rung, x_key) for rung in method["rungs"]]
    ys = [[run[key] ** exponent for run in rung["runs"]] for rung in method["rungs"]]
    axes.fill_between(xs, [min(y) for y in ys], [max(y) for y in ys], color=colour, alpha=0.2, lw=0)
    axes.plot(xs, [tables.median(y) for y in ys], "o-", ms=3.5, lw=1.4, color=colour, label=method["label"])
    floor = method["bias_floor"]
    if floor and floor["value"]:
        axes.axhline(floor["value"], color=colour, lw=1, ls="--", alpha=0.8)
        axes.annotate(f"bias of {method['label']}", (0.995, floor["value"]), xycoords=("axes fraction", "data"),
                      color=colour, fontsize=7, ha="right", va="bottom")


def error_figure(chart, x_key, x_title):
    """Log-log: medians over seeds, bands from the best to the worst seed, bias as a dashed line."""
    metric = chart["parameters"]["metric"]
    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    palette = colours(chart["methods"])
    for method in chart["methods"]:
        _draw_method(axes, method, x_key, metric, palette[method["label"]])
    axes.set(xscale="log", xlabel=x_title, ylabel=evaluate.METRICS[metric][2])
    firsts = [evaluate.medians(m["rungs"][0], x_key) for m in chart["methods"]]
    lasts = [evaluate.medians(m["rungs"][-1], x_key) for m in chart["methods"]]
    key, exponent, _ = evaluate.METRICS[metric]
    start = max(evaluate.medians(m["rungs"][0], key, exponent) for m in chart["methods"])
    if start > 0:  # else all is exact, and a logarithmic axis has no place for it
        axes.set_yscale("log", nonpositive="clip")
        _guide(axes, -1 / 2, "slope -1/2", min(firsts), max(lasts), start)
        _guide(axes, -1 / 3, "slope -1/3", min(firsts), max(lasts), start)
    axes.grid(True, which="major", color="0.9", lw=0.6)
    axes.legend(frameon=False, fontsize=8)
    axes.set_title(chart["title"], fontsize=9)
    return figure


def save(figure, path):
    """PNG or SVG without a date in it."""
    metadata = {"Date": None} if path.suffix == ".svg" else {"Software": None}
    figure.savefig(path, dpi=130, metadata=metadata)
    plt.close(figure)


def worst_place(image, truth):
    """(x, y, side) of the square where the image is farthest off, a sixteenth of the width or 8 pixels."""
    height, width = truth.shape[:2]
    side = min(max(8, width // ZOOM), height, width)
    squares = errors.relative_difference(image, truth) ** 2
    sums = np.pad(squares.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    boxes = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    y, x = np.unravel_index(np.argmax(boxes), boxes.shape)
    return int(x), int(y), side


def equal_time_choices(chart):
    """Per method the rung nearest to the longest time that all of them reach."""
    clock = evaluate.CLOCKS[chart["parameters"]["clock"]]
    times = {m["label"]: [evaluate.medians(rung, clock) for rung in m["rungs"]] for m in chart["methods"]}
    target = min(max(t) for t in times.values())
    return target, {label: tables.index_near(target, t) for label, t in times.items()}


def _show(axes, picture, title="", **options):
    axes.imshow(picture, interpolation="nearest", **options)
    axes.set(xticks=[], yticks=[])
    if title:
        axes.set_title(title, fontsize=8)


def contact_sheet(chart, folder, truth):
    """Images of seed 1 at equal time, signed differences, and the worst place of each beside the truth."""
    exposure = errors.exposure_for(truth)
    _, chosen = equal_time_choices(chart)
    key, exponent, name = evaluate.METRICS[chart["parameters"]["metric"]]
    clock = evaluate.CLOCKS[chart["parameters"]["clock"]]
    methods = chart["methods"]
    aspect = truth.shape[0] / truth.shape[1]
    width = 2.3
    figure, grid = plt.subplots(4, len(methods) + 1, squeeze=False, layout="constrained",
                                figsize=(width * (len(methods) + 1), width * (2 * aspect + 2) + 0.6),
                                gridspec_kw={"height_ratios": [aspect, aspect, 1, 1]})
    _show(grid[0][0], errors.tone_mapped(truth, exposure), "reference")
    for row, note in ((1, "signed difference,\nrelative: red too bright,\nblue too dark,\nfull colour at 50 %"),
                      (2, "worst place, framed above,\nexposed for itself"), (3, "the same place\nof the reference")):
        grid[row][0].axis("off")
        grid[row][0].text(0.5, 0.5, note, ha="center", va="center", fontsize=8, transform=grid[row][0].transAxes)
    for column, method in enumerate(methods, start=1):
        rung = method["rungs"][chosen[method["label"]]]
        run = rung["runs"][0]
        image = images.read(folder / run["image"])
        title = f"{method['label']}: {run[clock]:.3g} s\n{name} {run[key] ** exponent:.3g}"
        _show(grid[0][column], errors.tone_mapped(image, exposure), title)
        _show(grid[1][column], errors.relative_difference(image, truth), cmap="RdBu_r", vmin=-DIFFERENCE_RANGE,
              vmax=DIFFERENCE_RANGE)
        x, y, side = worst_place(image, truth)
        for row in (0, 1):
            grid[row][column].add_patch(plt.Rectangle((x - 0.5, y - 0.5), side, side, fill=False, ec="lime", lw=1))
        place = np.s_[y:y + side, x:x + side]
        local = errors.exposure_for(truth[place]) or exposure
        _show(grid[2][column], errors.tone_mapped(image[place], local), f"({x}, {y}), {side} pixels")
        _show(grid[3][column], errors.tone_mapped(truth[place], local))
    return figure
