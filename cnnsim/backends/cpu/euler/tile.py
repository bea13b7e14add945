"""Several Euler steps of one tile of the grid while its rows stay in the cache.

The tile's rows stream through ``depth`` levels, 16 rows at a time; level t holds the state after t steps and follows
level t-1 by r rows, which is all that a template of radius r needs to see. x and w exist once: each level replaces the
rows of x in place, and only the 2r rows of outputs that the next level still needs are kept for each level. The tile
is loaded with r cells more all round for each step; what comes in from outside spoils r of them a step, and what is
left at the end is exact. At the rim of the grid the virtual cells are set again at every level.
"""

from functools import cache
from typing import Any, NamedTuple

import numba
from numba import types

from cnnsim.backends.cpu.euler.rows import BLOCK, PAD, STRIDE
from cnnsim.backends.cpu.euler.scratch import (
    GROUP,
    PERIODIC,
    SLACK,
    Places,
    clip_rows,
    fill,
    load_row,
    move,
    set_virtual,
)
from cnnsim.backends.cpu.jit.address import compiled_at
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.jit.loops import step_block
from cnnsim.backends.cpu.settled import look_block
from cnnsim.support import Array


class Rule(NamedTuple):
    """A template's feedback, ready for the loops: their address, taps, radius, step, boundary and its constant."""

    loop: int
    r: int
    k: Array
    l: Array
    weight: Array
    square: Array
    h: float
    boundary: int
    constant: float


class Area(NamedTuple):
    """The cells [r0, r1) x [c0, c1) of a grid."""

    r0: int
    r1: int
    c0: int
    c1: int


@helper
def tile_area(tile: int, down: int, across: int, height: int, width: int, rows: int, cols: int) -> Area:
    """Return the cells of a tile; they are counted row by row, grid by grid."""
    r0, c0 = tile // across % down * height, tile % across * width
    return Area(r0, min(rows, r0 + height), c0, min(cols, c0 + width))


def stream(
    source: Array, w: Array, target: Array, rule: Rule, depth: int, area: Area, room: Array, at: Places,
    look: bool, rest: float, measure: bool, seen: Array,
) -> None:  # fmt: skip
    """Send a tile's rows through the levels; the last one goes to ``target``.

    With ``look`` (depth 1) nothing is written, but the step that would come is looked at (`look_block`).
    """
    rows, cols = source.shape
    loop, r, k, l, weight, square, h, boundary, constant = rule
    torus = boundary == PERIODIC
    reach = depth * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not torus:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    left, right = not torus and lo == 0, not torus and hi == cols
    n, inner, width = hi - lo, area.c0 - lo, area.c1 - area.c0
    whole = (n + PAD - 1) // PAD * PAD  # no remainder loops: the cells beyond n are never looked at
    used = whole + 2 * PAD
    for m in range(square.size):
        room[at.square + m] = square[m]
    y, new = at.y, at.new
    line = reach  # where row `base` lies among the live rows of x and w
    for base in range(top, area.r1 + reach, GROUP):
        if line > reach + SLACK:
            for p in range(reach):
                for live in (at.x, at.w):
                    move(room, live + (line - reach + p) * STRIDE, room, live + p * STRIDE, whole)
            line = reach
        through = False
        for level in range(depth + 1):
            i, margin = base - level * r, (depth - level) * r
            if i >= area.r1 + margin or (not torus and i >= rows + r):
                through = True  # this level has done its rows; the next one finds the last of them kept
                continue
            if i + GROUP <= area.r0 - margin or (not torus and i + GROUP <= 0):
                break  # this level and those after it have not begun
            if through:
                for p in range(2 * r):
                    move(room, at.kept + ((level - 1) * 2 * r + p) * STRIDE, room, y + p * STRIDE, used)
                through = False
            o, out = (line - level * r) * STRIDE, new + 2 * r * STRIDE
            blocks = (min(GROUP, area.r1 + margin - i) + BLOCK - 1) // BLOCK
            if level == 0:
                for q in range(GROUP):
                    if i + q < bottom:
                        load_row(source, i + q, lo, n, room, at.x + o + q * STRIDE, whole)
                        load_row(w, i + q, lo, n, room, at.w + o + q * STRIDE, whole)
                clip_rows(room, at.x + o, out, whole, GROUP)
            elif look:  # from x = 0 a step of length 1 goes to the drive, in the arithmetic of the steps
                for q in range(GROUP):
                    fill(room, at.drive + q * STRIDE, whole, 0)
                one = source.dtype.type(1)
                step_block(
                    loop, k, l, weight, r, room, at.row, at.square, at.drive, at.w + o, y, out, whole, one, blocks
                )
                for q in range(0, blocks * BLOCK, BLOCK):
                    x0, drive0 = at.x + o + inner + q * STRIDE, at.drive + inner + q * STRIDE
                    look_block(room, x0, drive0, area.r0, area.r1, i + q, width, area.c0, rest, measure, seen)
            else:
                step_block(loop, k, l, weight, r, room, at.row, at.square, at.x + o, at.w + o, y, out, whole, h, blocks)
            if level == depth:
                if not look:
                    for q in range(max(area.r0 - i, 0), min(area.r1 - i, GROUP)):
                        move(room, at.x + o + q * STRIDE + inner, target[i + q], area.c0, width)
                continue
            for p in range(2 * r):
                move(room, at.kept + (level * 2 * r + p) * STRIDE, room, new + p * STRIDE, used)
            if not torus:
                set_virtual(room, new, i, rows, n, left, right, r, boundary, constant)
            for p in range(2 * r):
                move(room, new + (GROUP + p) * STRIDE, room, at.kept + (level * 2 * r + p) * STRIDE, used)
            y, new = new, y
        line += GROUP


@cache
def streaming(rule: Any) -> Any:
    """Return `stream` compiled for rules of this numba type."""
    cells = rule.types[-1]
    plane, row = types.Array(cells, 2, "C"), types.Array(cells, 1, "C")
    area, places = numba.typeof(Area(0, 0, 0, 0)), numba.typeof(Places(0, 0, 0, 0, 0, 0, 0, 0))
    return compiled_at(
        stream,
        types.void(
            plane, plane, plane, rule, types.int64, area, row, places, types.boolean, types.float64, types.boolean,
            types.float64[::1],
        ),
    )  # fmt: skip
