"""Several Euler steps of one small window of the grid, all of its rows in the cache, and a check after them.

The arithmetic is that of `stream`, whose bookkeeping would cost more than the cells of small tiles that sleep.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import types

from cnnsim.backends.cpu.compiled import compiled_at, helper, uncounted
from cnnsim.backends.cpu.tiles.catch_up import catch_up_block
from cnnsim.backends.cpu.tiles.check import check_block
from cnnsim.backends.cpu.tiles.functions import copy_row, fill
from cnnsim.backends.cpu.tiles.grid import Area, Feedback
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE, step_blocks
from cnnsim.backends.cpu.tiles.scratch import (
    PERIODIC,
    cache_line,
    clip_rows,
    load_padded,
    set_sides,
    set_virtual_row,
)
from cnnsim.support import Array

HEIGHT, WIDTH = 16, 64
"""Rows (a multiple of `BLOCK`) and columns of a tile that is checked by itself: wide enough for vectors, and small
enough to fall asleep as a whole."""
MOST = 4
"""Tiles below each other that are stepped as one, so that the rows around them are computed once for all: of a picture
of 1024 x 1024 with holes the area computed is 18 % then, 25 % one by one, and 23 % by tiles twice as high."""


class WindowLayout(NamedTuple):
    """First cells of the rows of x and w, two sets of rows of y, a drive, a row, and pairs of cells."""

    x: int
    w: int
    y: int
    new: int
    drive: int
    row: int
    pairs: int


@helper
def _most_rows(depth: int, r: int) -> int:
    return MOST * HEIGHT + 2 * (depth + 2) * r + BLOCK


@helper
def window_cells(depth: int, r: int) -> int:
    """Return the size of a thread's scratch memory for at most ``depth`` steps."""
    return STRIDE * (4 * _most_rows(depth, r) + BLOCK + 4)


@helper
def _layout(scratch: Array, depth: int, r: int) -> WindowLayout:
    x, size = cache_line(scratch), STRIDE * _most_rows(depth, r)
    drive = x + 4 * size
    row = drive + BLOCK * STRIDE
    return WindowLayout(x, x + size, x + 2 * size, x + 3 * size, drive, row, row + STRIDE)


@helper
def _set_edges(
    scratch: Array, y: int, m: int, n: int, sides: tuple[bool, bool, bool, bool], edge: tuple[int, int, Any]
) -> None:
    """Set the virtual cells around m x n cells from row r of y, on the sides (top, bottom, left, right) of the grid."""
    (top, bottom, left, right), r = sides, edge[0]
    if left or right:
        for p in range(r, r + m):
            set_sides(scratch, y + p * STRIDE, n, (left, right), edge)
    for p in range(r):
        if top:
            set_virtual_row(scratch, y + p * STRIDE, y + r * STRIDE, n, edge)
        if bottom:
            set_virtual_row(scratch, y + (r + m + p) * STRIDE, y + (r + m - 1) * STRIDE, n, edge)


def step_window(
    planes: tuple[Array, Array, Array], feedback: Feedback, depth: int, area: Area, scratch: Array, behind: int,
    found: Array,
) -> None:  # fmt: skip
    """Take ``depth`` steps of the cells of an area and check the step that would come (`check_block`).

    ``planes`` are the states before, w, and the states after. ``found`` has a row for each `HEIGHT` rows. With
    ``behind`` instead take the missed steps of cells whose drive has stayed the same (`catch_up_block`).
    """
    source, w, target = uncounted(planes[0]), uncounted(planes[1]), uncounted(planes[2])
    loop, taps, square, h, r, code, constant = feedback
    taps, square, scratch, found = uncounted(taps), uncounted(square), uncounted(scratch), uncounted(found)
    (rows, cols), edge, at, one = source.shape, (r, code, constant), _layout(scratch, depth, r), scratch.dtype.type(1)
    periodic, reach = code == PERIODIC, (depth + 1) * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not periodic:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    m, n, inner, width = bottom - top, hi - lo, area.c0 - lo, area.c1 - area.c0
    own = not periodic
    sides = own and top == 0, own and bottom == rows, own and lo == 0, own and hi == cols
    whole, row = (n + PAD - 1) // PAD * PAD, scratch[at.row :]  # no remainder loops: cells beyond n are never read
    for p in range(m):
        load_padded(scratch, at.x + p * STRIDE, source, top + p, lo, n, whole)
        load_padded(scratch, at.w + p * STRIDE, w, top + p, lo, n, whole)
    for p in range(m * STRIDE, (m + -m % BLOCK) * STRIDE, STRIDE):  # stepped with the last ones
        fill(scratch[at.x + p : at.x + p + whole], 0)
        fill(scratch[at.w + p : at.w + p + whole], 0)
    y, new = at.y, at.new
    clip_rows(scratch, at.x, y + r * STRIDE, whole, m + -m % BLOCK)
    _set_edges(scratch, y, m, n, sides, edge)
    for level in range(1, depth + 1):
        margin = (depth + 1 - level) * r
        first, last = max(area.r0 - margin, top), min(area.r1 + margin, bottom)
        o = (first - top) * STRIDE
        block = scratch[at.x + o :], scratch[at.w + o :], scratch[y + o :], scratch[new + o + r * STRIDE :], row
        step_blocks(loop, square, taps, r, block, whole, h, (last - first + BLOCK - 1) // BLOCK)
        _set_edges(scratch, new, m, n, sides, edge)
        y, new = new, y
    pairs = 0
    for i in range(area.r0, area.r1, BLOCK):  # from x = 0 a step of length 1 goes to the drive, as a step computes it
        o = (i - top) * STRIDE
        for q in range(0, BLOCK * STRIDE, STRIDE):
            fill(scratch[at.drive + q : at.drive + q + whole], 0)
        block = scratch[at.drive :], scratch[at.w + o :], scratch[y + o :], scratch[new:], row
        step_blocks(loop, square, taps, r, block, whole, one, 1)
        x0, drive0 = at.x + o + inner, at.drive + inner
        if behind == 0:
            check_block(scratch, x0, drive0, area, i, found[min((i - area.r0) // HEIGHT, found.shape[0] - 1)])
        else:
            pairs = catch_up_block(scratch[x0:], scratch[drive0:], scratch[at.pairs :], row[:width], h, behind, pairs)
    for i in range(area.r0, area.r1 if depth > 0 or behind > 0 else area.r0):
        x0 = at.x + (i - top) * STRIDE + inner
        copy_row(target[i][area.c0 : area.c1], scratch[x0 : x0 + width])


@cache
def window(feedback: Any) -> Any:
    """Return `step_window` compiled for feedback of this numba type."""
    cells = feedback.types[3]
    plane, area = types.Array(cells, 2, "C"), numba.typeof(Area(0, 0, 0, 0))
    planes, row = types.UniTuple(plane, 3), types.Array(cells, 1, "C")
    integer, found = types.int64, types.float64[:, ::1]
    return compiled_at(step_window, types.void(planes, feedback, integer, area, row, integer, found))
