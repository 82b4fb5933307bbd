# SPDX-License-Identifier: Apache-2.0
"""From runs to the figures of chart.json."""
import math

import numpy as np

import errors
import images
import tables
from failure import InputError

CLOCKS = {"wall": "seconds", "cpu": "cpu_seconds"}
METRICS = {  # name on the command line -> key of a run, exponent that makes it a root mean square, title
    "rel-rmse": ("rel_mse", 0.5, "relative RMSE"),
    "rmse": ("rmse", 1.0, "RMSE"),
    "trimmed": ("trimmed_rel_mse", 0.5, "relative RMSE without the worst 0.1 % of pixels"),
}
SPLIT_KEYS = {"rel-rmse": "rel_bias_squared", "rmse": "bias_squared", "trimmed": "rel_bias_squared"}
_RUN_KEYS = ("seed", "command", "image", "seconds", "setup_seconds", "cpu_seconds", "rays", "load", "date")


def load_image(folder, record):
    """Pixels of a run."""
    return images.read(folder / record["image"])


def load_reference(folder, records, options):
    """Images that are the reference: one file or batches."""
    if options.reference:
        return [images.read(options.reference)]
    return [load_image(folder, record) for record in records]


def require_same_size(reference, image):
    """Raises InputError unless a run can be compared with the reference."""
    if image.shape != reference.shape:
        sizes = [f"{array.shape[1]} x {array.shape[0]}" for array in (reference, image)]
        raise InputError(f"the reference has {sizes[0]} pixels, the runs {sizes[1]}")


def _rung(folder, records, batches, truth, noise):
    pictures = [load_image(folder, record) for record in records]
    require_same_size(truth, pictures[0])
    run_list = [{**{key: record[key] for key in _RUN_KEYS}, **errors.measure(picture, truth)}
                for record, picture in zip(records, pictures)]
    rung = {"settings": records[0]["settings"], "runs": run_list}
    if len(pictures) > 1:
        rung["split"] = errors.split(pictures, batches, noise)
    return rung


def _missing(record):
    """What the ledger of a run says, as shares of the whole light.

    `against_reference` leaves out paths beyond the greatest depth, which the reference has not either.
    """
    if not record or not record["statistics"].get("missing"):
        return None
    ledger = record["statistics"]["missing"]
    truth = ledger["truth"]["luminance"] or 1.0
    shares = {name: entry["share"] for name, entry in ledger["entries"].items()}
    error = ledger["total"]["standard_error"] / truth
    return {
        "command": record["command"],
        "total": {"value": ledger["total"]["share"], "standard_error": error},
        "against_reference": {"value": ledger["total"]["share"] - shares.get("depth", 0.0), "standard_error": error},
        "entries": shares,
    }


def medians(rung, key, exponent=1.0):
    """Median over seeds of a figure, raised to a power."""
    return tables.median([run[key] for run in rung["runs"]]) ** exponent


def curve(method, metric, clock):
    """(times, errors) of a method, medians over seeds."""
    key, exponent, _ = METRICS[metric]
    rungs = method["rungs"]
    return [medians(r, CLOCKS[clock]) for r in rungs], [medians(r, key, exponent) for r in rungs]


def bias_floor(method, metric):
    """(root of bias^2, upper limit) at the dearest rung; the root is None where two standard errors hide it."""
    estimate = method["rungs"][-1].get("split", {}).get(SPLIT_KEYS[metric])
    if not estimate or not math.isfinite(estimate["standard_error"]):
        return None
    value, error = estimate["value"], estimate["standard_error"]
    upper = math.sqrt(max(value + 2 * error, 0.0))
    return {"value": math.sqrt(value) if value > 2 * error else None, "below": upper}


def evaluate(folder, methods, records, options):
    """Everything but date and machine."""
    batches = load_reference(folder, records["reference"], options)
    truth = np.mean(batches, axis=0)
    if not truth.mean() > 0:
        raise InputError("the reference is black: there is nothing to relate errors to")
    result = {"methods": [], "height": truth.shape[0], "width": truth.shape[1]}
    for method in methods:
        rungs = [_rung(folder, rung, batches, truth, options.reference_noise)
                 for rung in records["methods"][method["label"]]]
        entry = {"label": method["label"], "rungs": rungs,
                 "missing": _missing(records["ledger"].get(method["label"]))}
        entry["bias_floor"] = bias_floor(entry, options.metric)
        result["methods"].append(entry)
    result["reference"] = _describe_reference(records["reference"], batches, truth, result["methods"], options)
    curves = {m["label"]: curve(m, options.metric, options.clock) for m in result["methods"]}
    base = "path" if "path" in curves else methods[0]["label"]
    result["time_to_error"] = {"base": base, "rows": tables.time_table(curves, base)}
    return result, truth


def _describe_reference(records, batches, truth, methods, options):
    least = min(medians(rung, "rel_mse") for method in methods for rung in method["rungs"])
    if options.reference:
        source, relative = {"file": str(options.reference)}, options.reference_noise or None
        if options.reference_noise > least:
            raise InputError(f"--reference-noise: {options.reference_noise:g}, allowed: at most the least relMSE of all "
                             f"methods, {least:.3g}")
    else:
        count = len(batches)
        noise = sum((batch - truth) ** 2 for batch in batches) / max(count * (count - 1), 1)
        relative = float((noise / (truth ** 2 + errors.dark_term(truth))).mean()) if truth.any() else 0.0
        source = {"settings": records[0]["settings"], "batches": count,
                  "runs": [{key: record[key] for key in _RUN_KEYS} for record in records]}
    return {**source, "rel_variance": relative,
            "share_of_least_error": relative / least if relative is not None and least > 0 else None}
