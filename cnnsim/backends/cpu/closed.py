"""The closed form of uncoupled cells, compiled: `cnnsim.network.cell.uncoupled_state`, one cell at a time."""

import math

import numpy as np
from numba import prange

from cnnsim.backends.cpu.boundary import VirtualCells
from cnnsim.backends.cpu.drive import Control, control_row
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.backends.cpu.planes import all_true, finite_row
from cnnsim.support import Array


@helper
def through_linear(x: float, s: float, a: float, t: float, limited: bool) -> float:
    """Go from |x| <= 1 for the time t, into the saturation ahead (or up to the limit) if it is reached."""
    rate = (a - 1) * x + s
    if rate == 0:
        return x
    ahead = -1.0 if rate < 0 else 1.0
    x, s, rate = x * ahead, s * ahead, rate * ahead
    if a - 1 + s > 0:
        until_one = (1 - x) / rate if a == 1 else math.log1p((a - 1) * (1 - x) / rate) / (a - 1)
        if until_one <= t:
            return ahead * (1.0 if limited else (a + s) + (1 - a - s) * math.exp(-(t - until_one)))
    moved = rate * t if a == 1 else rate * math.expm1((a - 1) * t) / (a - 1)
    return ahead * (x + moved)


@helper
def cell_at(x: float, s: float, a: float, t: float, limited: bool) -> float:
    """Return the state of one cell at time t."""
    if limited or abs(x) <= 1:
        return through_linear(x, s, a, t, limited)
    side = -1.0 if x < 0 else 1.0
    size, push = x * side, s * side
    target = a + push
    if target < 1:
        until_one = math.log((size - target) / (1 - target))
        if until_one < t:
            return side * through_linear(1.0, push, a, t - until_one, limited)
    return side * (target + (size - target) * math.exp(-t))


@helper
def cell_at_rest(x: float, s: float, a: float, one: float, limited: bool) -> float:
    """Return the state one cell comes to: only comparisons, and no branches, so that it runs in vectors."""
    side = -one if x < 0 else one
    far = (not limited) & (abs(x) > one)
    stays = far & (a + s * side >= one)
    start = side if far else x
    rate = (a - one) * start + s
    ahead = -one if rate < 0 else one
    goes = (a - one) + s * ahead > 0
    there = ahead if limited else a * ahead + s
    there = there if goes else s / (one - a)
    there = start if rate == 0 else there
    there = a * side + s if stays else there
    return there if x - x == 0 else x  # NaN and infinity stay what they are, to be found


@twins
def closed_form(
    x: Array, end: Array, mask: Array, cell: tuple[float, float, bool], control: Control, virtual: VirtualCells,
    first: int, after: int,
) -> bool:  # fmt: skip
    """Write the states of cells that start at x, in the rows from ``first`` on, and return whether all are finite.

    Rows are counted through all grids, and each is looked at while it is near: another pass takes a fifth of the time.

    ``cell`` is (self-feedback a, time t or infinity, limited). A mask that is not given has no cells.
    """
    _, height, width = x.shape
    one = x.dtype.type(1)
    a, t, limited = cell
    z, bias, u, taps = control
    fine = np.empty(after - first, np.bool_)
    for line in prange(first, after):
        g, p = line // height, line % height
        row, drive = x[g, p], end[g, p]
        if bias.size:  # which may lie where the states go
            for j in range(width):
                drive[j] = z + bias[g, p, j]
        else:
            for j in range(width):
                drive[j] = z
        control_row(drive, u[g], p, taps, virtual)
        if t == math.inf:
            for j in range(width):
                drive[j] = cell_at_rest(row[j], drive[j], a, one, limited)
        else:
            for j in range(width):
                drive[j] = cell_at(row[j], drive[j], a, t, limited)
        if mask.size:
            for j in range(width):
                drive[j] = row[j] if mask[g, p, j] else drive[j]
        fine[line - first] = finite_row(drive)
    return all_true(fine)
