# SPDX-License-Identifier: Apache-2.0
"""Methods, and the settings that make each of them dearer step by step."""
import re

from failure import InputError

LEAST_RUNGS = 2
MOST_RUNGS = 12
FIRST_STEP = 4.0  # cost of the second rung over the first, before it is known


def parse_options(item):
    """['weights=full', 'lenient'] -> ['--weights', 'full', '--lenient']."""
    arguments = []
    for option in item:
        name, equals, value = option.partition("=")
        if not re.fullmatch(r"[a-z][a-z-]*", name):
            raise InputError(f"'{option}' is not an option of manylight-render: NAME or NAME=VALUE")
        arguments += [f"--{name}", value] if equals else [f"--{name}"]
    return arguments


def parse_methods(text):
    """'path,bdlc+weights=full' -> methods with their label and further arguments."""
    methods = []
    for label in text.split(","):
        name, *options = label.split("+")
        if not re.fullmatch(r"[a-z][a-z0-9_-]*", name):
            raise InputError(f"'{label}' in --methods is not METHOD or METHOD+OPTION=VALUE")
        methods.append({"label": label, "method": name, "arguments": parse_options(options)})
    labels = [method["label"] for method in methods]
    if len(set(labels)) < len(labels):
        raise InputError("a method stands twice in --methods")
    return methods


def settings(method, rung):
    """What manylight-render is told at a rung, counted from 0. Rung 0 of lightcuts and bdlc has the default number of eye
    paths, rung 2 that of lights.

    The noise of eye paths and the bias of few virtual lights fall together: cuts make lights cheap, so that these grow
    as the square of the eye paths. Fewer of both than rung 0 has would cost nearly as much, since the cut sets the
    cost: with an eighth of the eye paths it takes about half the time or more and has up to seven times the error.
    All pairs cost the product of both. Passes of pppm are alike but for their radius; the blur of photonmap falls with
    the photons only.
    """
    if method in ("path", "bdpt"):
        return {"spp": 4 * 4 ** rung}
    if method == "pppm":
        return {"spp": 4 * 4 ** rung, "photon-paths": 20_000}
    if method == "photonmap":
        return {"spp": 8 * 2 ** rung, "photon-paths": 10_000 * 2 ** rung}
    if method in ("vpl", "ir"):
        return {"eye-paths": 2 * 2 ** rung, "vpls": 250 * 2 ** rung}
    return {"eye-paths": 64 * 2 ** rung, "vpls": 64_000 * 4 ** rung}


def is_affordable(seconds, budget):
    """Whether a rung after those that took `seconds` ends within the budget, s; the first ones always do."""
    if len(seconds) < LEAST_RUNGS:
        return True
    if len(seconds) >= MOST_RUNGS:
        return False
    step = max(seconds[-1] / max(seconds[-2], 1e-6), 1.5) if len(seconds) > 1 else FIRST_STEP
    return seconds[-1] * step <= budget
