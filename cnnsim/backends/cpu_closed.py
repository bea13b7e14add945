"""The closed form of uncoupled cells, compiled: `cnnsim.cell.uncoupled_state`, one cell at a time."""

import math
from typing import Any

from numba import prange
from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import helper, twins

Array = NDArray[Any]


@helper
def through_linear(x: float, s: float, a: float, t: float, walls: bool) -> float:
    """Go from |x| <= 1 for the time t, into the saturation ahead (or up to the wall) if it is reached."""
    slope = (a - 1) * x + s
    if slope == 0:
        return x
    ahead = -1.0 if slope < 0 else 1.0
    x, s, slope = x * ahead, s * ahead, slope * ahead
    if a - 1 + s > 0:
        until_one = (1 - x) / slope if a == 1 else math.log1p((a - 1) * (1 - x) / slope) / (a - 1)
        if until_one <= t:
            return ahead * (1.0 if walls else (a + s) + (1 - a - s) * math.exp(-(t - until_one)))
    moved = slope * t if a == 1 else slope * math.expm1((a - 1) * t) / (a - 1)
    return ahead * (x + moved)


@helper
def cell_at(x: float, s: float, a: float, t: float, walls: bool) -> float:
    """Return the state of one cell at time t."""
    if walls or abs(x) <= 1:
        return through_linear(x, s, a, t, walls)
    side = -1.0 if x < 0 else 1.0
    size, push = x * side, s * side
    target = a + push
    if target < 1:
        until_one = math.log((size - target) / (1 - target))
        if until_one < t:
            return side * through_linear(1.0, push, a, t - until_one, walls)
    return side * (target + (size - target) * math.exp(-t))


@helper
def cell_at_rest(x: float, s: float, a: float, walls: bool) -> float:
    """Return the state one cell comes to: no exponentials, only comparisons."""
    if not walls and abs(x) > 1:
        side = -1.0 if x < 0 else 1.0
        if a + s * side >= 1:
            return a * side + s
        x = side
    slope = (a - 1) * x + s
    if slope == 0:
        return x
    ahead = -1.0 if slope < 0 else 1.0
    if a - 1 + s * ahead > 0:
        return ahead if walls else a * ahead + s
    return s / (1 - a)


@twins
def closed_form(x: Array, w: Array, held: Array, a: float, t: float, walls: bool) -> None:
    """Replace the state x of every free cell by the one at time t (infinite: at rest)."""
    n, height, width = x.shape
    for line in prange(n * height):
        g, p = line // height, line % height
        row, drive = x[g, p], w[g, p]
        for j in range(width):
            if held.size and held[g, p, j]:
                continue
            if t == math.inf:
                row[j] = cell_at_rest(row[j], drive[j], a, walls)
            else:
                row[j] = cell_at(row[j], drive[j], a, t, walls)
