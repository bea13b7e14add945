"""Several Euler steps of one small window of the grid, all of its rows in the cache, and a look at the step after.

The same arithmetic as `cnnsim.backends.cpu.euler.tile`, without the streaming: for the small tiles of
`cnnsim.backends.cpu.euler.sleep` its bookkeeping would cost more than the cells.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import types

from cnnsim.backends.cpu.euler.rows import BLOCK, PAD, STRIDE, catch_up_block
from cnnsim.backends.cpu.euler.scratch import PERIODIC, ZERO_FLUX, clip_rows, fill, load_row, move
from cnnsim.backends.cpu.euler.tile import Area, Rule
from cnnsim.backends.cpu.jit.address import compiled_at
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.jit.loops import step_block
from cnnsim.backends.cpu.settled import look_block
from cnnsim.support import Array

LOOK, CATCH_UP = 0, 1


class Shelf(NamedTuple):
    """Where things begin in a room: rows of x and w, two sets of rows of y, a drive, a row, nine entries of A."""

    x: int
    w: int
    y: int
    new: int
    drive: int
    row: int
    square: int


@helper
def shelf_rows(height: int, depth: int, r: int) -> int:
    """Return the most rows that a window ``height`` rows high needs for so many steps and a look."""
    return height + 2 * (depth + 2) * r + BLOCK


@helper
def window_cells(height: int, depth: int, r: int) -> int:
    """Return the size of one thread's room."""
    return STRIDE * (4 * shelf_rows(height, depth, r) + BLOCK + 3)


@helper
def shelve(room: Array, height: int, depth: int, r: int) -> Shelf:
    """Give each thing its place, the first at the start of a cache line."""
    x, size = ((64 - (room.ctypes.data & 63)) & 63) // room.itemsize, STRIDE * shelf_rows(height, depth, r)
    drive = x + 4 * size
    row = drive + BLOCK * STRIDE
    return Shelf(x, x + size, x + 2 * size, x + 3 * size, drive, row, row + STRIDE)


@helper
def set_edges(
    room: Array, y: int, m: int, n: int, top: bool, bottom: bool, left: bool, right: bool, r: int, kind: int, c: float
) -> None:
    """Set the virtual cells round m x n cells whose first row is row r of y, on the sides that are the grid's own."""
    if left or right:
        for p in range(r, r + m):
            o = y + p * STRIDE + PAD
            if left:
                fill(room, o - r, r, room[o] if kind == ZERO_FLUX else c)
            if right:
                fill(room, o + n, r, room[o + n - 1] if kind == ZERO_FLUX else c)
    for p in range(r):
        for there, row, nearest in ((top, p, r), (bottom, r + m + p, r + m - 1)):
            if there and kind == ZERO_FLUX:
                move(room, y + nearest * STRIDE, room, y + row * STRIDE, n + 2 * PAD)
            elif there:
                fill(room, y + row * STRIDE, n + 2 * PAD, c)


def step_window(
    source: Array, w: Array, target: Array, rule: Rule, depth: int, area: Area, room: Array, at: Shelf, task: int,
    rest: float, measure: bool, behind: int, seen: Array,
) -> None:  # fmt: skip
    """Take ``depth`` steps of the cells of ``area``, then do the task, and write the states to ``target``.

    LOOK: look at the step that would come (`look_block`). CATCH_UP: take the ``behind`` steps of cells whose drive has
    stayed the same (`catch_up_block`).
    """
    rows, cols = source.shape
    loop, r, k, l, weight, square, h, boundary, constant = rule
    torus, reach = boundary == PERIODIC, (depth + 1) * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not torus:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    m, n, inner = bottom - top, hi - lo, area.c0 - lo
    sides = not torus and top == 0, not torus and bottom == rows, not torus and lo == 0, not torus and hi == cols
    whole = (n + PAD - 1) // PAD * PAD  # no remainder loops: the cells beyond n are never looked at
    for q in range(square.size):
        room[at.square + q] = square[q]
    for p in range(m):
        load_row(source, top + p, lo, n, room, at.x + p * STRIDE, whole)
        load_row(w, top + p, lo, n, room, at.w + p * STRIDE, whole)
    y, new = at.y, at.new
    for p in range(0, m, BLOCK):
        clip_rows(room, at.x + p * STRIDE, y + (r + p) * STRIDE, whole, BLOCK)
    set_edges(room, y, m, n, *sides, r, boundary, constant)
    for level in range(1, depth + 1):
        margin = (depth + 1 - level) * r
        first, last = max(area.r0 - margin, top), min(area.r1 + margin, bottom)
        o, blocks = (first - top) * STRIDE, (last - first + BLOCK - 1) // BLOCK
        step_block(loop, k, l, weight, r, room, at.row, at.square, at.x + o, at.w + o, y + o, new + o + r * STRIDE,
                   whole, h, blocks)  # fmt: skip
        set_edges(room, new, m, n, *sides, r, boundary, constant)
        y, new = new, y
    for i in range(area.r0, area.r1, BLOCK):  # from x = 0 a step of length 1 goes to the drive, as a step computes it
        o = (i - top) * STRIDE
        for q in range(BLOCK):
            fill(room, at.drive + q * STRIDE, whole, 0)
        step_block(loop, k, l, weight, r, room, at.row, at.square, at.drive, at.w + o, y + o, new, whole,
                   source.dtype.type(1), 1)  # fmt: skip
        if task == LOOK:
            look_block(room, at.x + o + inner, at.drive + inner, area.r0, area.r1, i, area.c1 - area.c0, area.c0, rest,
                       measure, seen)  # fmt: skip
        else:
            catch_up_block(room, at.x + o + inner, at.drive + inner, area.c1 - area.c0, h, behind)
    if depth > 0 or task != LOOK:
        for i in range(area.r0, area.r1):
            move(room, at.x + (i - top) * STRIDE + inner, target[i], area.c0, area.c1 - area.c0)


@cache
def window(rule: Any) -> Any:
    """Return `step_window` compiled for rules of this numba type."""
    cells = rule.types[-1]
    plane, row = types.Array(cells, 2, "C"), types.Array(cells, 1, "C")
    area, shelf = numba.typeof(Area(0, 0, 0, 0)), numba.typeof(Shelf(0, 0, 0, 0, 0, 0, 0))
    return compiled_at(
        step_window,
        types.void(
            plane, plane, plane, rule, types.int64, area, row, shelf, types.int64, types.float64, types.boolean,
            types.int64, types.float64[::1],
        ),
    )  # fmt: skip
