"""Several steps of one tile of the grid while its rows stay in the cache: Euler steps, or stages of Runge-Kutta steps.

The tile's rows stream through levels, 16 rows at a time; level t holds the state after t Euler steps, or after t
stages, and follows level t-1 by r rows, which is all that a template of radius r needs to see. x and w exist once: each
level replaces the rows of x in place, and only the 2r rows of outputs that the next level still needs are kept for each
level. The same is true of the stage and of the sum that a Runge-Kutta step has beside x (`stage_rows`). The tile is
loaded with r cells more all round for each level; what comes in from outside spoils r of them a level, and what is left
at the end is exact. At the rim of the grid the virtual cells are set again at every level.
"""

from functools import cache
from typing import Any

import numba
from numba import types

from cnnsim.backends.cpu.jit.address import compiled_at
from cnnsim.backends.cpu.tiles.boundary import is_periodic, set_virtual
from cnnsim.backends.cpu.tiles.grid import Area, Feedback, levels_of
from cnnsim.backends.cpu.tiles.loops import step_block
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE
from cnnsim.backends.cpu.tiles.scratch import GROUP, SLACK, TileLayout, clip_rows, fill, load_bits, load_row, move
from cnnsim.backends.cpu.tiles.settled import check_block
from cnnsim.backends.cpu.tiles.stage_rows import CHECK, NOWHERE, StageOf, stage_rows
from cnnsim.support import Array


def stream(
    source: Array, w: Array, mask: Array, target: Array, feedback: Feedback, depth: int, area: Area, scratch: Array,
    at: TileLayout, check: bool, rest: float, measure: bool, found: Array,
) -> None:  # fmt: skip
    """Send a tile's rows through the levels; the last one goes to ``target``.

    With ``check`` (depth 1) nothing is written, but the step that would come is checked (`check_block`). The words of
    a ``mask`` without cells hold none; only steps of stages know one.
    """
    rows, cols = source.shape
    loop, taps, numbers, h, r, code, constant, stages, lives, limited = feedback
    edge = r, code, constant
    periodic, masked = is_periodic(edge), mask.size > 0
    levels = 1 if check else levels_of(depth, feedback)
    reach = levels * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not periodic:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    left, right = not periodic and lo == 0, not periodic and hi == cols
    n, inner, width = hi - lo, area.c0 - lo, area.c1 - area.c0
    whole = (n + PAD - 1) // PAD * PAD  # no remainder loops: the cells beyond n are never read
    used = whole + 2 * PAD
    for m in range(numbers.size):
        scratch[at.numbers + m] = numbers[m]
    at_held = at.w + at.size
    at_stage = at_held + at.size if masked else at_held
    keeps = lives > 4 + masked
    y, new = at.y, at.new
    line = reach  # where row `base` lies among the live rows of x and w
    for base in range(top, area.r1 + reach, GROUP):
        if line > reach + SLACK:
            for p in range(reach):
                for m in range(lives):
                    live = at.x + m * at.size + p * STRIDE
                    move(scratch, live + (line - reach) * STRIDE, scratch, live, whole)
            line = reach
        through = False
        for level in range(levels + 1):
            i, margin = base - level * r, (levels - level) * r
            if i >= area.r1 + margin or (not periodic and i >= rows + r):
                through = True  # this level has done its rows; the next one finds the last of them kept
                continue
            if i + GROUP <= area.r0 - margin or (not periodic and i + GROUP <= 0):
                break  # this level and those after it have not begun
            if through:
                for p in range(2 * r):
                    move(scratch, at.kept + ((level - 1) * 2 * r + p) * STRIDE, scratch, y + p * STRIDE, used)
                through = False
            o, out = (line - level * r) * STRIDE, new + 2 * r * STRIDE
            blocks = (min(GROUP, area.r1 + margin - i) + BLOCK - 1) // BLOCK
            begin, end = max(area.r0 - margin, top), min(area.r1 + margin, bottom)
            some = max(begin - i, 0), min(end - i, GROUP)
            of = StageOf(
                CHECK if check else (level - 1) % max(1, stages), stages, keeps, limited, at.numbers, at.row,
                at_stage + o, at_held + o if masked else NOWHERE,
            )  # fmt: skip
            if level == 0:
                for q in range(GROUP):
                    if i + q < bottom:
                        load_row(source, i + q, lo, n, scratch, at.x + o + q * STRIDE, whole)
                        load_row(w, i + q, lo, n, scratch, at.w + o + q * STRIDE, whole)
                        if masked:
                            load_bits(mask, i + q, lo, n, cols, scratch, at_held + o + q * STRIDE, whole)
                clip_rows(scratch, at.x + o, out, whole, GROUP)
            elif check:  # from x = 0 a step of length 1 goes to the drive, in the arithmetic of the steps
                if stages:
                    stage_rows(loop, scratch, at.x + o, at.size, y, at.drive, whole, taps, r, of, some)
                else:
                    for q in range(GROUP):
                        fill(scratch, at.drive + q * STRIDE, whole, 0)
                    step_block(loop, taps, r, scratch, at.row, at.numbers, at.drive, at.w + o, y, out, whole,
                               source.dtype.type(1), blocks)  # fmt: skip
                for q in range(0, blocks * BLOCK, BLOCK):
                    x0, drive0 = at.x + o + inner + q * STRIDE, at.drive + inner + q * STRIDE
                    check_block(scratch, x0, drive0, area, i + q, rest, measure, found)
            elif stages:
                stage_rows(loop, scratch, at.x + o, at.size, y, out, whole, taps, r, of, some)
            else:
                step_block(loop, taps, r, scratch, at.row, at.numbers, at.x + o, at.w + o, y, out, whole, h, blocks)
            if level == levels:
                if not check:
                    for q in range(max(area.r0 - i, 0), min(area.r1 - i, GROUP)):
                        move(scratch, at.x + o + q * STRIDE + inner, target[i + q], area.c0, width)
                continue
            for p in range(2 * r):
                move(scratch, at.kept + (level * 2 * r + p) * STRIDE, scratch, new + p * STRIDE, used)
            if not periodic:
                set_virtual(scratch, new, i, rows, n, (left, right), edge)
            for p in range(2 * r):
                move(scratch, new + (GROUP + p) * STRIDE, scratch, at.kept + (level * 2 * r + p) * STRIDE, used)
            y, new = new, y
        line += GROUP


@cache
def streaming(feedback: Any) -> Any:
    """Return `stream` compiled for feedback of this numba type."""
    cells = feedback.types[3]
    plane, row, words = types.Array(cells, 2, "C"), types.Array(cells, 1, "C"), types.Array(types.uint64, 2, "C")
    area, layout = numba.typeof(Area(0, 0, 0, 0)), numba.typeof(TileLayout(0, 0, 0, 0, 0, 0, 0, 0, 0))
    return compiled_at(
        stream,
        types.void(
            plane, plane, words, plane, feedback, types.int64, area, row, layout, types.boolean, types.float64,
            types.boolean, types.float64[::1],
        ),
    )  # fmt: skip
