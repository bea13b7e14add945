"""One stage of a Runge-Kutta step, row by row, its data in the first-level cache: the innermost loops of the stages.

Everything lies in one flat array, laid out as in `cnnsim.backends.cpu.tiles.rows`, and is handed over once for each of
its uses, as there. Sums are rounded like the reference's, in float32 too:

    k_i = w + sum of the taps of y_i in their order - x_i
    x_i = x + sum of h a_ij k_j over j < i,    x <- x + sum of h b_i k_i

The sum that the step ends with is added up stage by stage. So a stage leaves no more behind than that sum and the next
stage, unless a later stage but one asks for its rate: then all rates are kept.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import carray, types

from cnnsim.backends.cpu.jit.address import call, compiled_at, pointer, pointer_type
from cnnsim.backends.cpu.jit.columns import tap_type
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.row_sums import (
    add_weighted,
    copy_cells,
    drives,
    keep_held,
    nine_rates,
    outputs,
    set_held,
    stop_at_limits,
    subtract,
    sum_and_output,
    weighted_onto,
    weighted_sum,
)
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.support import Array

NOWHERE = -1
"""Where there is no mask."""
CHECK = -1
"""In place of a stage: write the drives, for a check."""


class StageOf(NamedTuple):
    """A ``stage`` of so many ``stages``, whether rates are kept, whether states stay within +-1; and where the scheme's
    table begins (see `table_of`), a row of scratch, live rows of the stage, and of the mask (`NOWHERE`).
    """

    stage: int
    stages: int
    keeps: bool
    limited: bool
    at_table: int
    at_row: int
    at_stage: int
    at_held: int


@helper
def _go_on(scratch: Array, at_x: int, at_out: int, size: int, n: int, of: StageOf, o: int) -> None:
    """Go from the rates of a stage, in the row of scratch, to the next stage or to the end of the step."""
    s, count, rate, stage = of.stage, of.stages, of.at_row, of.at_stage + o
    weight, total = scratch[of.at_table + count * count + s], of.at_stage + size + o
    if s + 1 == count:
        if s > 0 and of.at_held == NOWHERE:
            sum_and_output(scratch, at_x, scratch, at_out, scratch, total, weight, scratch, rate, n)
        else:  # x itself is needed until the end
            weighted_onto(scratch, rate, scratch, at_x if s == 0 else total, weight, n)
            if of.at_held != NOWHERE:
                keep_held(scratch, rate, scratch, of.at_held + o, scratch, at_x, n)
            outputs(scratch, at_out, scratch, rate, n)
            copy_cells(scratch, at_x, scratch, rate, n)
        if of.limited:
            copy_cells(scratch, at_x, scratch, at_out, n)
        return
    if s == 0:
        weighted_sum(scratch, total, scratch, at_x, weight, scratch, rate, n)
    else:
        add_weighted(scratch, total, weight, scratch, rate, n)
    ahead = of.at_table + (s + 1) * count
    if of.keeps:
        kept = total + size
        copy_cells(scratch, kept + s * size, scratch, rate, n)
        copy_cells(scratch, stage, scratch, at_x, n)
        for earlier in range(s + 1):
            add_weighted(scratch, stage, scratch[ahead + earlier], scratch, kept + earlier * size, n)
        outputs(scratch, at_out, scratch, stage, n)
    else:
        sum_and_output(scratch, stage, scratch, at_out, scratch, at_x, scratch[ahead + s], scratch, rate, n)
    if of.limited:
        copy_cells(scratch, stage, scratch, at_out, n)


@helper
def _stage_rows(
    scratch: Array, at_x: int, size: int, at_y: int, at_out: int, n: int, taps: Array, r: int, of: StageOf,
    some: tuple[int, int],
) -> None:  # fmt: skip
    """Do a stage with some rows, or write what drives them; ``size`` is the distance between sets of live rows."""
    for q in range(some[0], some[1]):
        o = q * STRIDE
        x, w, y, out = at_x + o, at_x + size + o, at_y + o, at_out + o
        if of.stage == CHECK:
            drives(scratch, w, y, taps, r, out, n)
            if of.limited:
                stop_at_limits(scratch, out, scratch, x, n)
            if of.at_held != NOWHERE:  # as what is saturated, which a check lets pass
                one = scratch.dtype.type(1)
                set_held(scratch, out, scratch, of.at_held + o, one, n)
                set_held(scratch, x, scratch, of.at_held + o, one, n)
            continue
        state = x if of.stage == 0 else of.at_stage + o
        if taps.size == 9 and r == 1:
            nine_rates(scratch, of.at_row, scratch, w, scratch, y, scratch, state, taps, n)
        else:
            drives(scratch, w, y, taps, r, of.at_row, n)
            subtract(scratch, of.at_row, scratch, state, n)
        if of.at_held != NOWHERE:  # held in the stages, too: their neighbours see the stages
            set_held(scratch, of.at_row, scratch, of.at_held + o, scratch.dtype.type(0), n)
        _go_on(scratch, x, out + PAD, size, n, of, o)


def _stage_at(
    numbers: Any, cells: int, at_x: int, size: int, at_y: int, at_out: int, n: int, taps: Any, tap_count: int, r: int,
    stage: int, stages: int, keeps: bool, limited: bool, at_table: int, at_row: int, at_stage: int, at_held: int,
    first: int, after: int,
) -> None:  # fmt: skip
    of, some = StageOf(stage, stages, keeps, limited, at_table, at_row, at_stage, at_held), (first, after)
    _stage_rows(carray(numbers, (cells,)), at_x, size, at_y, at_out, n, carray(taps, (tap_count,)), r, of, some)


@cache
def stage_loop(dtype: np.dtype[Any]) -> Any:
    """Return what `stage_rows` calls, compiled for a dtype."""
    integer, yes = types.int64, types.boolean
    cells, taps = pointer_type(dtype), pointer_type(tap_type(dtype))
    return compiled_at(
        _stage_at,
        types.void(cells, *6 * [integer], taps, *4 * [integer], yes, yes, *6 * [integer]),
    )


@helper
def stage_rows(
    loop: int, scratch: Array, at_x: int, size: int, at_y: int, at_out: int, n: int, taps: Array, r: int, of: StageOf,
    some: tuple[int, int],
) -> None:  # fmt: skip
    """Do a stage with some rows, from the first to that after them, by the loop at an address; of a check (`CHECK`) the
    drives go to ``at_out``.
    """
    call(loop, (pointer(scratch), scratch.size, at_x, size, at_y, at_out, n, pointer(taps), taps.size, r, of.stage,
                of.stages, of.keeps, of.limited, of.at_table, of.at_row, of.at_stage, of.at_held, some[0],
                some[1]))  # fmt: skip
