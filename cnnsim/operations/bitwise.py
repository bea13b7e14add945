"""Bit rules: templates that are an AND or OR of neighbours on black-and-white pictures, found by truth table."""

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cnnsim.network import Boundary, Template, reach
from cnnsim.network.cell import uncoupled_state

MOST_NEIGHBOURS = 12
"""Templates that read more cells than this are not tried: the truth table has 2^n rows."""

CLEAR = 1e-6
"""A drive closer to a change of the output gives no rule: rounding decides there, so the transient is computed."""


class BitLiteral(NamedTuple):
    """The neighbour at (row + k, col + l), or its negation."""

    k: int
    l: int
    negated: bool


@dataclass(frozen=True)
class BitRule:
    """A cell turns black if all of its literals are true (``conjunction``), or if any of them is."""

    literals: tuple[BitLiteral, ...]
    conjunction: bool

    @property
    def radius(self) -> int:
        """Chessboard distance of the farthest literal from the cell."""
        return reach((k, l) for k, l, _ in self.literals)


def bit_rule(template: Template, boundary: Boundary, state: float | None) -> BitRule | None:
    """Return the rule by which a settled uncoupled template turns a black-and-white input into x > 0, or None.

    ``state`` is x(0), a number, or None if x(0) is the input picture. Erosion, dilation, hit-and-miss, shifts and
    NOT are such rules; majority is not. Fixed virtual cells must be black or white as well.

        s = z + sum of b (+-1),    out = x_rest(x0, s, a) > 0
    """
    if not template.linear or not template.uncoupled or any(abs(u) != 1 for _, u in boundary.constants):
        return None
    weights = {(tap.k, tap.l): tap.weight for tap in template.control_taps}
    if state is None:
        weights.setdefault((0, 0), 0.0)
    if len(weights) > MOST_NEIGHBOURS:
        return None
    table = np.array(list(itertools.product((-1.0, 1.0), repeat=len(weights))))
    drive = template.z + table @ np.array(list(weights.values()))
    start = np.full_like(drive, state) if state is not None else table[:, list(weights).index((0, 0))]
    black, surely, possibly = (
        uncoupled_state(start, drive + e, template.self_feedback, math.inf, "chua-yang") > 0
        for e in (0.0, -CLEAR, CLEAR)
    )
    if not (np.array_equal(surely, black) and np.array_equal(possibly, black)):
        return None
    for conjunction in (True, False):
        rare = black if conjunction else ~black  # an AND is true, an OR false, on one cube of the table
        if not rare.any():
            continue
        fixed = [i for i in range(len(weights)) if np.ptp(table[rare, i]) == 0]
        if rare.sum() != 2 ** (len(weights) - len(fixed)):
            continue
        places = list(weights)
        wanted = [bool(table[rare][0, i] > 0) for i in fixed]
        literals = (BitLiteral(*places[i], w != conjunction) for i, w in zip(fixed, wanted, strict=True))
        return BitRule(tuple(literals), conjunction)
    return None
