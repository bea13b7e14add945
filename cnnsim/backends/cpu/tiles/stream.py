"""Several Euler steps of one tile of the grid while its rows stay in the cache.

The tile's rows stream through levels, 16 rows at a time. Level t holds the state after t steps and follows level t-1 by
r rows, which is all that a template of radius r needs to see. x and w exist once: each level replaces the rows of x in
place, and for each level only the 2r rows of outputs are kept that the next level still needs. The tile is loaded with
r more cells on all sides for each level; each level spoils r of them, and the rest is exact. At the edge of the grid
the virtual cells are set at every level.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import types

from cnnsim.backends.cpu.compiled import compiled_at, helper, uncounted
from cnnsim.backends.cpu.tiles.check import check_block
from cnnsim.backends.cpu.tiles.functions import copy_row, fill
from cnnsim.backends.cpu.tiles.grid import Area, Feedback
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE, step_blocks
from cnnsim.backends.cpu.tiles.scratch import (
    PERIODIC,
    cache_line,
    clip_rows,
    load_padded,
    move,
    set_sides,
    set_virtual_row,
)
from cnnsim.support import Array

GROUP = 4 * BLOCK
"""Rows that a level of a tile steps at a time: the last ones are kept once for all of them."""
SLACK = 16
"""Rows that stream past before the live ones are moved back to the start of their buffer."""
CHECK = 0
"""In place of a number of steps: check the cells."""


class StreamLayout(NamedTuple):
    """First cells of the live rows of x and w, two groups of y, the kept rows of y of each level, a drive and a row."""

    x: int
    w: int
    y: int
    new: int
    kept: int
    drive: int
    row: int


@helper
def stream_cells(depth: int, r: int) -> int:
    """Return the size of a thread's scratch memory."""
    return STRIDE * (2 * (depth * r + GROUP + SLACK) + 2 * (GROUP + 2 * r) + 2 * r * depth + GROUP + 2)


@helper
def stream_layout(scratch: Array, depth: int, r: int) -> StreamLayout:
    """Return where the buffers begin; the first begins a cache line."""
    x, live, block = cache_line(scratch), STRIDE * (depth * r + GROUP + SLACK), STRIDE * (GROUP + 2 * r)
    y = x + 2 * live
    kept = y + 2 * block
    drive = kept + STRIDE * 2 * r * depth
    return StreamLayout(x, x + live, y, y + block, kept, drive, drive + STRIDE * GROUP)


@helper
def _set_virtual(
    scratch: Array, at: int, i0: int, rows: int, n: int, sides: tuple[bool, bool], edge: tuple[int, int, Any]
) -> None:
    """Set the virtual cells of a group of rows of y whose rows from 2r are the grid's rows from i0.

    Rows above the grid are the r rows before row 0, which are still in the group when row 0 comes.
    """
    r = edge[0]
    for q in range(GROUP):
        o, i = at + (q + 2 * r) * STRIDE, i0 + q
        if i >= rows:
            set_virtual_row(scratch, o, o - STRIDE, n, edge)
        set_sides(scratch, o, n, sides, edge)
        if i == 0:
            for p in range(1, r + 1):
                set_virtual_row(scratch, o - p * STRIDE, o, n, edge)


def stream(
    planes: tuple[Array, Array, Array], feedback: Feedback, steps: int, area: Area, scratch: Array, found: Array
) -> None:
    """Take ``steps`` of the cells of an area; ``planes`` are the states before, w, and the states after.

    `CHECK`: write nothing but check the step that would come (`check_block`).
    """
    source, w, target = uncounted(planes[0]), uncounted(planes[1]), uncounted(planes[2])
    loop, taps, square, h, r, code, constant = feedback
    taps, square, scratch, found = uncounted(taps), uncounted(square), uncounted(scratch), uncounted(found)
    check, levels, (rows, cols), edge = steps == CHECK, max(1, steps), source.shape, (r, code, constant)
    at, one, reach, periodic = stream_layout(scratch, levels, r), scratch.dtype.type(1), levels * r, code == PERIODIC
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not periodic:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    sides = not periodic and lo == 0, not periodic and hi == cols
    n, inner, width = hi - lo, area.c0 - lo, area.c1 - area.c0
    whole = (n + PAD - 1) // PAD * PAD  # no remainder loops: the cells beyond n are never read
    used, row, y, new = whole + 2 * PAD, scratch[at.row :], at.y, at.new
    line = reach  # where row `base` lies among the live rows of x and w
    for base in range(top, area.r1 + reach, GROUP):
        if line > reach + SLACK:
            for p in range(0, reach * STRIDE, STRIDE):
                for live in (at.x, at.w):
                    move(scratch, live + p + (line - reach) * STRIDE, live + p, whole)
            line = reach
        through = False
        for level in range(levels + 1):
            i, margin = base - level * r, (levels - level) * r
            if i >= area.r1 + margin or (not periodic and i >= rows + r):
                through = True  # this level has done its rows; the next one finds the last of them kept
                continue
            if i + GROUP <= area.r0 - margin or (not periodic and i + GROUP <= 0):
                break  # this level and those after it have not begun
            kept = at.kept + level * 2 * r * STRIDE
            if through:
                for p in range(0, 2 * r * STRIDE, STRIDE):
                    move(scratch, kept - 2 * r * STRIDE + p, y + p, used)
                through = False
            o, out = (line - level * r) * STRIDE, new + 2 * r * STRIDE
            blocks = (min(GROUP, area.r1 + margin - i) + BLOCK - 1) // BLOCK
            if level == 0:
                for q in range(GROUP):
                    if i + q < bottom:
                        load_padded(scratch, at.x + o + q * STRIDE, source, i + q, lo, n, whole)
                        load_padded(scratch, at.w + o + q * STRIDE, w, i + q, lo, n, whole)
                clip_rows(scratch, at.x + o, out, whole, GROUP)
            elif check:  # from x = 0 a step of length 1 goes to the drive, in the arithmetic of the steps
                for q in range(0, GROUP * STRIDE, STRIDE):
                    fill(scratch[at.drive + q : at.drive + q + whole], 0)
                block = scratch[at.drive :], scratch[at.w + o :], scratch[y:], scratch[out:], row
                step_blocks(loop, square, taps, r, block, whole, one, blocks)
                for q in range(0, blocks * BLOCK, BLOCK):
                    x0, drive0 = at.x + o + inner + q * STRIDE, at.drive + inner + q * STRIDE
                    check_block(scratch, x0, drive0, area, i + q, found)
            else:
                block = scratch[at.x + o :], scratch[at.w + o :], scratch[y:], scratch[out:], row
                step_blocks(loop, square, taps, r, block, whole, h, blocks)
            if level == levels:
                for q in range(max(area.r0 - i, 0), 0 if check else min(area.r1 - i, GROUP)):
                    x0 = at.x + o + q * STRIDE + inner
                    copy_row(target[i + q][area.c0 : area.c1], scratch[x0 : x0 + width])
                continue
            for p in range(0, 2 * r * STRIDE, STRIDE):
                move(scratch, kept + p, new + p, used)
            if not periodic:
                _set_virtual(scratch, new, i, rows, n, sides, edge)
            for p in range(0, 2 * r * STRIDE, STRIDE):
                move(scratch, new + GROUP * STRIDE + p, kept + p, used)
            y, new = new, y
        line += GROUP


@cache
def streaming(feedback: Any) -> Any:
    """Return `stream` compiled for feedback of this numba type."""
    cells = feedback.types[3]
    plane, area = types.Array(cells, 2, "C"), numba.typeof(Area(0, 0, 0, 0))
    planes, row = types.UniTuple(plane, 3), types.Array(cells, 1, "C")
    return compiled_at(stream, types.void(planes, feedback, types.int64, area, row, types.float64[::1]))
