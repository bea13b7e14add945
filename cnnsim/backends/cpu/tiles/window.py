"""Several Euler steps of one small window of the grid, all of its rows in the cache, and a check after them.

The same arithmetic as `cnnsim.backends.cpu.tiles.tile`, without the streaming: for the small tiles of
`cnnsim.backends.cpu.tiles.sleep` its bookkeeping would cost more than the cells.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import types

from cnnsim.backends.cpu.jit.address import compiled_at
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.boundary import is_periodic, set_edges
from cnnsim.backends.cpu.tiles.catch_up import catch_up_block
from cnnsim.backends.cpu.tiles.grid import Area, Feedback
from cnnsim.backends.cpu.tiles.loops import step_block
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE
from cnnsim.backends.cpu.tiles.scratch import clip_rows, fill, load_row, move
from cnnsim.backends.cpu.tiles.settled import check_block
from cnnsim.support import Array

CHECK, CATCH_UP = 0, 1
HEIGHT = 16
"""Rows of a tile that is checked by itself: a multiple of `BLOCK`."""


class WindowLayout(NamedTuple):
    """Where things begin: rows of x and w, two sets of rows of y, a drive, a row, nine entries of A, pairs of cells."""

    x: int
    w: int
    y: int
    new: int
    drive: int
    row: int
    square: int
    pairs: int


@helper
def window_rows(height: int, depth: int, r: int) -> int:
    """Return the most rows that a window ``height`` rows high needs for so many steps and a check."""
    return height + 2 * (depth + 2) * r + BLOCK


@helper
def window_cells(height: int, depth: int, r: int) -> int:
    """Return the size of a thread's scratch."""
    return STRIDE * (4 * window_rows(height, depth, r) + BLOCK + 4)


@helper
def window_layout(scratch: Array, height: int, depth: int, r: int) -> WindowLayout:
    """Lay the buffers out, the first at the start of a cache line."""
    x, size = ((64 - (scratch.ctypes.data & 63)) & 63) // scratch.itemsize, STRIDE * window_rows(height, depth, r)
    drive = x + 4 * size
    row = drive + BLOCK * STRIDE
    return WindowLayout(x, x + size, x + 2 * size, x + 3 * size, drive, row, row + STRIDE, row + 2 * STRIDE)


def step_window(
    source: Array, w: Array, target: Array, feedback: Feedback, depth: int, area: Area, scratch: Array,
    at: WindowLayout, task: int, rest: float, measure: bool, behind: int, found: Array,
) -> None:  # fmt: skip
    """Take ``depth`` steps of the cells of ``area``, then do the task, and write the states to ``target``.

    CHECK: check the step that would come (`check_block`); ``found`` has a row for each tile of `HEIGHT` rows, the last
    one for all that are left. CATCH_UP: take the ``behind`` steps of cells whose drive
    has stayed the same (`catch_up_block`).
    """
    rows, cols = source.shape
    loop, taps, square, h, r, code, constant, _, _, _ = feedback
    edge = r, code, constant
    periodic, reach = is_periodic(edge), (depth + 1) * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not periodic:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    m, n, inner = bottom - top, hi - lo, area.c0 - lo
    own = not periodic
    sides = own and top == 0, own and bottom == rows, own and lo == 0, own and hi == cols
    whole = (n + PAD - 1) // PAD * PAD  # no remainder loops: the cells beyond n are never read
    for q in range(square.size):
        scratch[at.square + q] = square[q]
    for p in range(m):
        load_row(source, top + p, lo, n, scratch, at.x + p * STRIDE, whole)
        load_row(w, top + p, lo, n, scratch, at.w + p * STRIDE, whole)
    for p in range(m, m + -m % BLOCK):  # stepped with the last ones, as `load_row` has it of columns
        fill(scratch, at.x + p * STRIDE, whole, 0)
        fill(scratch, at.w + p * STRIDE, whole, 0)
    y, new = at.y, at.new
    for p in range(0, m, BLOCK):
        clip_rows(scratch, at.x + p * STRIDE, y + (r + p) * STRIDE, whole, BLOCK)
    set_edges(scratch, y, m, n, sides, edge)
    for level in range(1, depth + 1):
        margin = (depth + 1 - level) * r
        first, last = max(area.r0 - margin, top), min(area.r1 + margin, bottom)
        o, blocks = (first - top) * STRIDE, (last - first + BLOCK - 1) // BLOCK
        step_block(loop, taps, r, scratch, at.row, at.square, at.x + o, at.w + o, y + o, new + o + r * STRIDE,
                   whole, h, blocks)  # fmt: skip
        set_edges(scratch, new, m, n, sides, edge)
        y, new = new, y
    pairs = 0
    for i in range(area.r0, area.r1, BLOCK):  # from x = 0 a step of length 1 goes to the drive, as a step computes it
        o = (i - top) * STRIDE
        for q in range(BLOCK):
            fill(scratch, at.drive + q * STRIDE, whole, 0)
        step_block(loop, taps, r, scratch, at.row, at.square, at.drive, at.w + o, y + o, new, whole,
                   source.dtype.type(1), 1)  # fmt: skip
        if task == CHECK:
            tile = min((i - area.r0) // HEIGHT, found.shape[0] - 1)
            check_block(scratch, at.x + o + inner, at.drive + inner, area, i, rest, measure, found[tile])
        else:
            pairs = catch_up_block(scratch, at.x + o + inner, at.drive + inner, at.pairs, at.row, area.c1 - area.c0, h,
                                   behind, pairs)  # fmt: skip
    if depth > 0 or task != CHECK:
        for i in range(area.r0, area.r1):
            move(scratch, at.x + (i - top) * STRIDE + inner, target[i], area.c0, area.c1 - area.c0)


@cache
def window(feedback: Any) -> Any:
    """Return `step_window` compiled for feedback of this numba type."""
    cells = feedback.types[3]
    plane, row = types.Array(cells, 2, "C"), types.Array(cells, 1, "C")
    area, layout = numba.typeof(Area(0, 0, 0, 0)), numba.typeof(WindowLayout(0, 0, 0, 0, 0, 0, 0, 0))
    return compiled_at(
        step_window,
        types.void(
            plane, plane, plane, feedback, types.int64, area, row, layout, types.int64, types.float64, types.boolean,
            types.int64, types.float64[:, ::1],
        ),
    )  # fmt: skip
