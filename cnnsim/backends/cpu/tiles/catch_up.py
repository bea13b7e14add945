"""Steps that a sleeping tile missed, taken at once: its cells go towards drives that stayed, x <- x + h (drive - x).

Cells with the same state and the same drive go the same way, and in a tile that sleeps there are few such pairs: in
black and white as many as a neighbourhood has sums. So the way of a pair is gone once, and its end is looked up for the
others. Steps follow one another, so the few pairs of a vector cost what one cell does.
"""

import numpy as np

from cnnsim.backends.cpu.jit.compile import fused, helper
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE
from cnnsim.support import Array

PAIRS = PAD
"""Pairs that are kept: a vector of float32, and more than there are sums of eight neighbours of one colour."""


def _go(x: Array, drive: Array, first: int, after: int, h: float, steps: int) -> None:
    """Take so many steps of some cells, until no bit changes any more."""
    for _ in range(steps):
        changes = np.int32(0)
        for j in range(first, after):
            v = x[j] + h * (drive[j] - x[j])
            changes += np.int32(v != x[j])
            x[j] = v
        if changes == 0:
            break


go_fused, go_exact = fused(_go), helper(_go)


@helper
def _go_on(x: Array, drive: Array, first: int, after: int, h: float, steps: int) -> None:
    if x.itemsize == 4:
        go_fused(x, drive, first, after, h, steps)
    else:
        go_exact(x, drive, first, after, h, steps)


@helper
def _look_up(x: Array, drive: Array, pairs: Array, count: int, ends: Array, n: int) -> int:
    """Write the ends of the cells whose pairs are known; return how many they are."""
    hits = np.int32(0)
    for k in range(count):
        of, to, end = pairs[k], pairs[PAIRS + k], pairs[2 * PAIRS + k]
        for j in range(n):
            same = (x[j] == of) & (drive[j] == to)
            ends[j] = end if same else ends[j]
            hits += np.int32(same)
    return int(hits)


@helper
def _add(x: Array, drive: Array, pairs: Array, count: int, n: int) -> int:
    """Add the pairs of a row that are not known; return how many there are then, `PAIRS` + 1 if they are too many."""
    for j in range(n):
        known = False
        for k in range(count):
            known |= (x[j] == pairs[k]) & (drive[j] == pairs[PAIRS + k])
        if known:
            continue
        if count == PAIRS:
            return count + 1
        pairs[count], pairs[PAIRS + count], pairs[2 * PAIRS + count] = x[j], drive[j], x[j]
        count += 1
    return count


@helper
def catch_up_block(
    scratch: Array, at_x: int, at_drive: int, at_pairs: int, at_row: int, n: int, h: float, steps: int, count: int
) -> int:
    """Take the steps that a block has slept through, with the rounding of every single one.

    ``at_pairs`` has the states, drives and ends of ``count`` pairs of these steps; returns how many there are then.
    """
    pairs, ends = scratch[at_pairs : at_pairs + 3 * PAIRS], scratch[at_row : at_row + n]
    for q in range(0, BLOCK * STRIDE, STRIDE):
        x, drive = scratch[at_x + q : at_x + q + n], scratch[at_drive + q : at_drive + q + n]
        if _look_up(x, drive, pairs, count, ends, n) < n:
            now = _add(x, drive, pairs, count, n)
            if now > PAIRS:
                _go_on(x, drive, 0, n, h, steps)
                continue
            _go_on(pairs[2 * PAIRS :], pairs[PAIRS:], count, now, h, steps)
            count = now
            _look_up(x, drive, pairs, count, ends, n)
        for j in range(n):
            x[j] = ends[j]
    return count
