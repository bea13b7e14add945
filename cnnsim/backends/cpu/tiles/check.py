"""Checks whether a network has settled: the largest |dx/dt|, and the area of cells that are not saturated for good.

A cell is saturated for good if |x| >= 1 and sign(x) d >= 1 for its drive d = A*y + w. While the outputs of its
neighbours are constant, d is constant. A step x + h (d - x) with h <= 1 then keeps |x| >= 1: the exact value lies
between x and d, rounding is monotonic, and 1 is a floating-point number. So the output keeps every bit.
"""

from typing import Any

import numpy as np

from cnnsim.backends.cpu.compiled import helper, without_nan
from cnnsim.backends.cpu.tiles.grid import Area
from cnnsim.backends.cpu.tiles.rows import BLOCK, STRIDE
from cnnsim.support import Array

RATE, R0, R1, C0, C1 = range(5)
"""Results of a check: the largest |dx/dt|, and rows [R0, R1) and columns [C0, C1) of the cells that are not saturated
for good; R0 is infinite if there are none."""
FIGURES = 5


@helper
def saturated(x: float, drive: float, one: float) -> bool:
    """Return whether a cell is saturated for good: its output is constant while its neighbours' outputs are."""
    return ((x >= one) & (drive >= one)) | ((x <= -one) & (drive <= -one))


@helper
def start_check(found: Array) -> None:
    """Start a check."""
    found[RATE] = 0
    found[R0] = found[C0] = np.inf
    found[R1] = found[C1] = -np.inf


@helper
def all_saturated(found: Array) -> bool:
    """Return whether all checks found only saturated cells; a helper, because numba would thread the loop."""
    count = 0
    for i in range(found.shape[0]):
        count += found[i, R0] < np.inf
    return count == 0


@helper
def largest_of(found: Array) -> float:
    """Return the largest |dx/dt| of all checks."""
    largest = 0.0
    for i in range(found.shape[0]):
        largest = max(largest, found[i, RATE])
    return largest


@without_nan
def _check_row(x: Array, drive: Array) -> tuple[Any, float]:
    """Return how many cells are not saturated for good, and the largest |dx/dt|."""
    one, largest, unsaturated = x.dtype.type(1), x.dtype.type(0), np.int32(0)
    for j in range(x.size):
        unsaturated += np.int32(not saturated(x[j], drive[j], one))
        largest = max(largest, abs(drive[j] - x[j]))
    return unsaturated, largest


@helper
def check_block(scratch: Array, at_x: int, at_drive: int, area: Area, i: int, found: Array) -> None:
    """Add to ``found`` the rows and columns of ``area`` that lie in a block of rows i .. i + 3."""
    one, n = scratch.dtype.type(1), area.c1 - area.c0
    for q in range(max(area.r0 - i, 0), min(area.r1 - i, BLOCK)):
        x = scratch[at_x + q * STRIDE : at_x + q * STRIDE + n]
        drive = scratch[at_drive + q * STRIDE : at_drive + q * STRIDE + n]
        unsaturated, rate = _check_row(x, drive)
        found[RATE] = max(found[RATE], rate)
        if unsaturated:
            found[R0], found[R1] = min(found[R0], i + q), max(found[R1], i + q + 1)
            first, last = 0, n - 1
            while saturated(x[first], drive[first], one):
                first += 1
            while saturated(x[last], drive[last], one):
                last -= 1
            found[C0], found[C1] = min(found[C0], area.c0 + first), max(found[C1], area.c0 + last + 1)
