"""Hard inputs: NaN, infinities, negative zeros, denormals and the largest numbers in every plane."""

from typing import Any

import numpy as np

from cnnsim import Template, run_transient
from cnnsim.backends.base import Backend
from cnnsim.support import Array
from tests.hard_cases.case import HardCase

TEMPLATE = Template([[0, 0.2, 0], [0.2, 0.5, 0.2], [0, 0.2, 0]], 0.5)
FLAT = np.zeros((3, 4))


def _run(**planes: Any) -> Any:
    def ours(backend: Backend) -> Array:
        given = {"state": FLAT, "input": FLAT, **planes}
        return run_transient(TEMPLATE, **given, duration=1.0, backend=backend).x

    return ours


def _with(value: float) -> Array:
    plane = FLAT.copy()
    plane[1, 2] = value
    return plane


SPREAD = "it would spread over the grid by one cell a step"
SIGN = "the sign of zero must not become the sign of an output"
SMALL = "5e-324 is below float32's smallest number, and halves to 0"

CASES = [
    *(
        HardCase(f"{value} in the {plane}", SPREAD, _run(**{plane: _with(value)}), refused="finite")
        for plane in ("state", "input", "bias", "mask")
        for value in (float("nan"), float("inf"), float("-inf"))
    ),
    *(
        HardCase(f"-0.0 in the {plane}", SIGN, _run(**{plane: -FLAT}), lambda: FLAT, 0.0, 0.0)
        for plane in ("state", "input", "bias")
    ),
    HardCase("denormals", SMALL, _run(state=np.full((3, 4), 5e-324)), lambda: FLAT, 1e-320, 0.0),
]
