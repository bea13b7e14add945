"""A look at the step that would come: what would still move, and which cells are not saturated for good.

A cell is stuck if |x| >= 1 and its drive d = A*y + w pulls it outwards: sign(x) d >= 1. While its neighbours' outputs
stay, so does d, and a step x + h (d - x) with h <= 1 cannot bring it back inside: the exact value lies between x and d,
and rounding keeps the order of numbers and 1 is one of them. So its output stays, to the bit.
"""

import numpy as np

from cnnsim.backends.cpu.euler.rows import BLOCK, STRIDE
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array

STEEPEST, MOVING, RESTLESS, R0, R1, C0, C1 = range(7)
"""What a look puts down: the largest |dx/dt| (if it is measured), how many cells have |dx/dt| above the rest slope, how
many are not saturated for good, and the area that those lie in."""


@helper
def stuck(x: float, drive: float, one: float) -> bool:
    """Return whether a cell is saturated for good, as long as its neighbours' outputs stay."""
    return ((x >= one) & (drive >= one)) | ((x <= -one) & (drive <= -one))


@helper
def look_at_nothing(seen: Array) -> None:
    """Start a look."""
    seen[STEEPEST] = seen[MOVING] = seen[RESTLESS] = 0
    seen[R0] = seen[C0] = np.inf
    seen[R1] = seen[C1] = -np.inf


@helper
def total(seen: Array, what: int) -> float:
    """Add up one figure of many looks; a helper, because in a threaded loop numba would start the threads for it."""
    so_far = 0.0
    for i in range(seen.shape[0]):
        so_far += seen[i, what]
    return so_far


@helper
def steepest(seen: Array) -> float:
    """Return the largest |dx/dt| of many looks; NaN if there is one."""
    largest = 0.0
    for i in range(seen.shape[0]):
        if not seen[i, STEEPEST] <= largest:
            largest = seen[i, STEEPEST]
    return largest


@helper
def look_block(
    room: Array, at_x: int, at_drive: int, r0: int, r1: int, i: int, n: int, c0: int, rest: float, measure: bool,
    seen: Array,
) -> None:  # fmt: skip
    """Put down in ``seen`` what moves in rows r0 .. r1 - 1 of a block of rows i .. i + 3, n columns from c0 on."""
    one, still = room.dtype.type(1), room.dtype.type(rest)
    for q in range(max(r0 - i, 0), min(r1 - i, BLOCK)):
        first, to = at_x + q * STRIDE, at_drive + q * STRIDE
        row, pull = room[first : first + n], room[to : to + n]
        moving, restless = np.int32(0), np.int32(0)
        for j in range(n):
            moving += np.int32(not abs(pull[j] - row[j]) <= still)
            restless += np.int32(not stuck(row[j], pull[j], one))
        seen[MOVING] += moving
        seen[RESTLESS] += restless
        if restless:
            seen[R0], seen[R1] = min(seen[R0], i + q), max(seen[R1], i + q + 1)
            first, last = 0, n - 1
            while stuck(row[first], pull[first], one):
                first += 1
            while stuck(row[last], pull[last], one):
                last -= 1
            seen[C0], seen[C1] = min(seen[C0], c0 + first), max(seen[C1], c0 + last + 1)
        if measure:
            for j in range(n):
                slope = abs(pull[j] - row[j])
                if not slope <= seen[STEEPEST]:
                    seen[STEEPEST] = slope
