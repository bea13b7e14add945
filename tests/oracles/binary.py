"""Expected outputs of the binary templates, from their definitions, without a network.

The rules of windows and the answers to whole pictures come from each template's task, so that a wrong number in a
template file cannot hide.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.oracles.pictures import Case, Picture, Plane, black, plane
from tests.oracles.wholes import (
    columns_of,
    count_diagonal,
    count_down,
    count_right,
    count_right_behind,
    drop_damaged,
    erase_from_left,
    fill_concavities,
    fill_holes,
    framed_areas,
    horizontal_runs,
    reconstruct,
    shadow,
    shadow_left_behind,
)
from tests.oracles.windows import LOGIC, RULES, window_answer


def _of_input(answer: Callable[[Picture], Picture]) -> Callable[[Case], Plane]:
    return lambda case: plane(answer(black(case.picture)))


def _of_both(answer: Callable[[Picture, Picture], Picture]) -> Callable[[Case], Plane]:
    """An answer from the initial state and the input, in this order."""

    def solve(case: Case) -> Plane:
        assert case.u is not None and case.x0 is not None
        return plane(answer(black(case.x0), black(case.u)))

    return solve


def _window(name: str) -> Callable[[Case], Plane]:
    return _of_input(lambda picture: window_answer(name, picture))


def _mirrored(
    answer: Callable[[Picture, Picture], Picture],
) -> Callable[[Picture, Picture], Picture]:
    return lambda x, u: answer(x[:, ::-1], u[:, ::-1])[:, ::-1]


ANSWERS: dict[str, Callable[[Case], Plane]] = {
    **{name: _window(name) for name in RULES if name != "edge-gray"},
    **{name: _of_both(lambda x, u, rule=rule: rule(u, x)) for name, rule in LOGIC.items()},  # type: ignore[misc]
    "fill-black": _of_input(np.ones_like),
    "fill-white": _of_input(np.zeros_like),
    "hole-filler": _of_input(fill_holes),
    "shadow-left": _of_input(lambda p: shadow(p, "left")),
    "shadow-right": _of_input(lambda p: shadow(p, "right")),
    "shadow-up": _of_input(lambda p: shadow(p, "up")),
    "shadow-down": _of_input(lambda p: shadow(p, "down")),
    "shadow-vertical": _of_input(columns_of),
    "connected-components-horizontal": _of_input(count_right),
    "connected-components-vertical": _of_input(count_down),
    "connected-components-diagonal": _of_input(count_diagonal),
    "masked-connected-components-right": _of_both(count_right_behind),
    "masked-connected-components-left": _of_both(_mirrored(count_right_behind)),
    "recall": _of_both(reconstruct),
    "figure-reconstructor": _of_both(reconstruct),
    "connectivity": _of_both(lambda x, u: drop_damaged(u, x)),
    "concave-filler": _of_input(fill_concavities),
    "masked-erase": _of_both(erase_from_left),
    "masked-shadow": _of_both(shadow_left_behind),
    "framed-areas": _of_input(framed_areas),
    "horizontal-line-detector": _of_input(horizontal_runs),
}
"""The answer of every binary template that has an independent definition, to a worked example."""
