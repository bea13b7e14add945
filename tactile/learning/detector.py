"""Detector files of learned templates."""

from math import ceil, log2

import numpy as np

from tactile.learning.fit import RELEASE, Learned
from tactile.learning.front import TOUCH


def detector_text(one: Learned, name: str, kind: str, source: str) -> str:
    """Return the detector file of a learned template, whose event is ``kind``; ``source`` says from what it is learned.

    Each plane has a template that adds its part to the drive. All weights are divided by one power of two, so that the
    sum stays within +-1, the range of an output.
    """
    unit = 2.0 ** -ceil(log2(float((np.abs(one.weights) * (1, 8)).sum() + abs(one.z))))
    templates, steps = [], [*one.front.steps, f'{{ fill = {one.z * unit}, to = "drive" }},']
    for n, (plane, (own, ring)) in enumerate(zip(one.front.names, one.weights.tolist(), strict=True)):
        c, r = own * unit, ring * unit
        b = f"[[{r}, {r}, {r}], [{r}, {c}, {r}], [{r}, {r}, {r}]]" if r else f"[[{c}]]"
        templates.append(f'part-{n} = {{ A = [[0]], B = {b}, boundary = "zero-flux" }}  # {plane}')
        steps.append(f'{{ template = "part-{n}", input = "{plane}", state = 0, bias = "drive", to = "drive" }},')
    steps += [
        '{ copy = "drive", to = "black" },', f'{{ logic = "and", of = ["black", "{TOUCH}"], to = "black" }},',
        '{ wire = "count", of = "black", to = "marked" },',
    ]  # fmt: skip
    wires = ["marked", "on"]
    if one.most:
        wires = ["marked", "twice", "touched", "on"]
        steps += [
            '{ number = "multiply", of = ["marked", 2], to = "twice" },',
            f'{{ wire = "count", of = "{TOUCH}", to = "touched" }},',
            '{ number = "less", of = ["touched", "twice"], to = "on" },',
        ]
    else:
        steps += ['{ number = "less", of = [0, "marked"], to = "on" },']
    summary = f"{kind.replace('_', ' ').capitalize()}, by a template learned from {source}."
    head = one.front.head(name, summary, ["black", "on"], (["drive"], ["black"], wires))
    times = {"confirm_ms": one.confirm, "release_ms": RELEASE, "lag_ms": one.lag}
    return "\n".join([
        head, "step = [", *(f"  {step}" for step in steps), "]", "", "[templates]", *templates, "", "[[event]]",
        f'kind       = "{kind}"', 'when       = "on"', 'taxels     = "black"',
        *(f"{key:<10} = {1e3 * value:g}" for key, value in times.items()),
    ]) + "\n"  # fmt: skip
