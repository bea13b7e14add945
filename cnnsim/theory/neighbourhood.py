"""Neighbourhoods of black-and-white pictures: pairs of initial state and input, sums of taps, and all their values."""

from collections.abc import Sequence

import numpy as np

from cnnsim.support import Floats

Pair = tuple[float, float]
"""(x(0), u) of one cell."""

MOST = 1 << 18
"""Most different sums of an enumeration."""
DIGITS = 9
"""Decimals of a sum of weights; the others are rounding."""


def pairs_of(input: str | float, initial_state: str | float) -> list[Pair] | str:  # noqa: A002 - the field's word for u
    """Return the pairs (x(0), u) that a cell can have in black-and-white pictures.

    The roles are those of a template file. The initial state "any" is represented by its extremes.
    """
    both = (-1.0, 1.0)
    if input == "picture" and initial_state == "picture":
        return [(v, v) for v in both]
    us = both if input == "picture" else (0.0,) if input == "none" else (float(input),)
    if initial_state in ("picture", "given", "any"):
        states: Sequence[float] = both
    else:
        states = (float(initial_state),)
    return [(x0, u) for x0 in states for u in us]


def weighted_sums(options: Sequence[Sequence[tuple[float, ...]]]) -> Floats | None:
    """Return all different sums of one vector from each list, as rows; None if there are more than `MOST`.

    Sums are rounded to `DIGITS` decimals.
    """
    width = len(options[0][0]) if options else 1
    sums = np.zeros((1, width))
    for choices in options:
        sums = (sums[:, None, :] + np.array(sorted(set(choices)))[None, :, :]).reshape(-1, width)
        sums = np.unique(np.round(sums, DIGITS), axis=0)
        if len(sums) > MOST:
            return None
    return sums


def too_many(taps: int) -> str:
    """Return the reason for an enumeration of more than `MOST` sums."""
    return f"its {taps} taps have more than {MOST} different sums"
