# SPDX-License-Identifier: Apache-2.0
"""Figures that a chart is read for: time to reach an error, speed-ups."""
import math

NOT_REACHED = "not reached"
FROM_THE_START = "from the start"


def median(values):
    """Of any number of values."""
    ordered = sorted(values)
    middle = len(ordered) // 2
    return ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle])


def levels_between(lowest, highest):
    """1, 2 and 5 times powers of ten in [lowest, highest], from the highest on."""
    if not 0 < lowest <= highest < math.inf:
        return []
    exponents = range(math.floor(math.log10(lowest)), math.ceil(math.log10(highest)) + 1)
    levels = [float(f"{digit}e{exponent}") for exponent in exponents for digit in (1, 2, 5)]
    return sorted((level for level in levels if lowest <= level <= highest), reverse=True)


def time_to(level, times, errors):
    """Seconds at which the line through the points, straight in log-log, first falls to `level`.

    Nothing is extrapolated: NOT_REACHED above the last point, FROM_THE_START below the first.
    """
    if errors[0] <= level:
        return FROM_THE_START
    for i in range(len(errors) - 1):
        if errors[i] > level >= errors[i + 1]:
            if errors[i + 1] <= 0:
                return times[i + 1]
            share = math.log(errors[i] / level) / math.log(errors[i] / errors[i + 1])
            return times[i] * (times[i + 1] / times[i]) ** share
    return NOT_REACHED


def time_table(curves, base):
    """Rows of {level, times, speed_ups}; `curves` are (times, errors) by label. Speed-ups over `base`."""
    every = [error for _, errors in curves.values() for error in errors if 0 < error < math.inf]
    rows = []
    for level in levels_between(min(every), max(every)) if every else []:
        times = {label: time_to(level, *curve) for label, curve in curves.items()}
        speed_ups = {}
        if isinstance(times[base], float):
            speed_ups = {label: times[base] / t for label, t in times.items() if isinstance(t, float)}
        rows.append({"level": level, "times": times, "speed_ups": speed_ups})
    return rows


def index_near(target, times):
    """Index of the time nearest to `target` on a logarithmic scale."""
    return min(range(len(times)), key=lambda i: abs(math.log(times[i] / target)))
