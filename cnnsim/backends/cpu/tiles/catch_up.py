"""Steps that a sleeping tile missed, taken in one call: its cells approach constant drives, x <- x + h (drive - x).

Cells with the same pair (state, drive) end in the same state. A sleeping tile has few different pairs: in black and
white at most the number of sums of a neighbourhood. Each pair is stepped once, and all cells with it get the result.
"""

import numpy as np

from cnnsim.backends.cpu.compiled import fused, helper
from cnnsim.backends.cpu.tiles.functions import copy_row
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE
from cnnsim.support import Array

PAIRS = PAD
"""Most pairs (state, drive) in the table: a vector of float32, more than the sums of eight neighbours of one colour."""


def _go(x: Array, drive: Array, h: float, steps: int) -> None:
    for _ in range(steps):
        changes = np.int32(0)
        for j in range(x.size):
            v = x[j] + h * (drive[j] - x[j])
            changes += np.int32(v != x[j])
            x[j] = v
        if changes == 0:
            break


_go_fused, _go_exact = fused(_go), helper(_go)


@helper
def _go_on(x: Array, drive: Array, h: float, steps: int) -> None:
    """Take ``steps`` steps of some cells, or fewer if a step changes no bit."""
    if x.itemsize == 4:
        _go_fused(x, drive, h, steps)
    else:
        _go_exact(x, drive, h, steps)


@helper
def _look_up(x: Array, drive: Array, pairs: Array, count: int, ends: Array) -> int:
    """Write the final states of the cells whose pairs are in the table; return the number of these cells."""
    hits = np.int32(0)
    for k in range(count):
        of, to, end = pairs[k], pairs[PAIRS + k], pairs[2 * PAIRS + k]
        for j in range(x.size):
            same = (x[j] == of) & (drive[j] == to)
            ends[j] = end if same else ends[j]
            hits += np.int32(same)
    return int(hits)


@helper
def _add(x: Array, drive: Array, pairs: Array, count: int) -> int:
    """Add the pairs (state, drive) of a row to the table; return their number, `PAIRS` + 1 if the table is full."""
    for j in range(x.size):
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
def catch_up_block(xs: Array, drives: Array, pairs: Array, ends: Array, h: float, steps: int, count: int) -> int:
    """Take the missed steps of a block of rows; each step is rounded.

    ``pairs`` has the states, drives and final states of ``count`` pairs. Returns the new number of pairs. ``ends`` is a
    row of scratch memory as long as the rows of the block.
    """
    n = ends.size
    for q in range(0, BLOCK * STRIDE, STRIDE):
        x, drive = xs[q : q + n], drives[q : q + n]
        if _look_up(x, drive, pairs, count, ends) < n:
            now = _add(x, drive, pairs, count)
            if now > PAIRS:
                _go_on(x, drive, h, steps)
                continue
            _go_on(pairs[2 * PAIRS + count : 2 * PAIRS + now], pairs[PAIRS + count : PAIRS + now], h, steps)
            count = now
            _look_up(x, drive, pairs, count, ends)
        copy_row(x, ends)
    return count
