"""Whether tiles have settled: what would still move in the step to come, and which cells are not saturated for good.

A cell is saturated for good if |x| >= 1 and its drive d = A*y + w pulls it outwards: sign(x) d >= 1. While its
neighbours' outputs stay, so does d, and a step x + h (d - x) with h <= 1 cannot bring it back inside: the exact value
lies between x and d, and rounding keeps the order of numbers and 1 is one of them. So its output stays, to the bit.
"""

import numpy as np

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.grid import Area
from cnnsim.backends.cpu.tiles.rows import BLOCK, STRIDE
from cnnsim.support import Array

RATE, MOVING, UNSATURATED, R0, R1, C0, C1 = range(7)
"""What a check finds: the largest |dx/dt| (if it is measured), how many cells have |dx/dt| above the rate of rest, how
many are not saturated for good, and the area that those lie in."""
FIGURES = 7


@helper
def saturated(x: float, drive: float, one: float) -> bool:
    """Return whether a cell is saturated for good, as long as its neighbours' outputs stay."""
    return ((x >= one) & (drive >= one)) | ((x <= -one) & (drive <= -one))


@helper
def start_check(found: Array) -> None:
    """Start a check."""
    found[RATE] = found[MOVING] = found[UNSATURATED] = 0
    found[R0] = found[C0] = np.inf
    found[R1] = found[C1] = -np.inf


@helper
def total(found: Array, what: int) -> float:
    """Add up one figure of many checks; a helper, because in a threaded loop numba would start the threads for it."""
    so_far = 0.0
    for i in range(found.shape[0]):
        so_far += found[i, what]
    return so_far


@helper
def largest_rate(found: Array) -> float:
    """Return the largest |dx/dt| of many checks; NaN if there is one."""
    largest = 0.0
    for i in range(found.shape[0]):
        if not found[i, RATE] <= largest:
            largest = found[i, RATE]
    return largest


@helper
def check_block(
    scratch: Array, at_x: int, at_drive: int, area: Area, i: int, rest: float, measure: bool, found: Array
) -> None:
    """Add to ``found`` what moves in the rows and columns of ``area`` that lie in a block of rows i .. i + 3."""
    one, still, n = scratch.dtype.type(1), scratch.dtype.type(rest), area.c1 - area.c0
    for q in range(max(area.r0 - i, 0), min(area.r1 - i, BLOCK)):
        first, to = at_x + q * STRIDE, at_drive + q * STRIDE
        row, drive = scratch[first : first + n], scratch[to : to + n]
        moving, unsaturated = np.int32(0), np.int32(0)
        for j in range(n):
            moving += np.int32(not abs(drive[j] - row[j]) <= still)
            unsaturated += np.int32(not saturated(row[j], drive[j], one))
        found[MOVING] += moving
        found[UNSATURATED] += unsaturated
        if unsaturated:
            found[R0], found[R1] = min(found[R0], i + q), max(found[R1], i + q + 1)
            first, last = 0, n - 1
            while saturated(row[first], drive[first], one):
                first += 1
            while saturated(row[last], drive[last], one):
                last -= 1
            found[C0], found[C1] = min(found[C0], area.c0 + first), max(found[C1], area.c0 + last + 1)
        if measure:
            for j in range(n):
                rate = abs(drive[j] - row[j])
                if not rate <= found[RATE]:
                    found[RATE] = rate
