"""One stage of a Runge-Kutta step, row by row, its data in the first-level cache: the innermost loops of the stages.

Everything lies in one flat array, laid out as in `cnnsim.backends.cpu.euler.rows`, and is handed over once for each of
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

from cnnsim.backends.cpu.euler.rows import PAD, STRIDE, min_max
from cnnsim.backends.cpu.jit.address import call, compiled_at, pointer, pointer_type
from cnnsim.backends.cpu.jit.columns import tap_type
from cnnsim.backends.cpu.jit.compile import helper
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
def _nine_rates(
    out: Array, at_out: int, w: Array, at_w: int, y: Array, at_y: int, x: Array, at_x: int, taps: Array, n: int
) -> None:
    """Write w + A*y - x by a 3 x 3 matrix without a zero."""
    out, w, x, y = out[at_out : at_out + n], w[at_w : at_w + n], x[at_x : at_x + n], y[at_y : at_y + 3 * STRIDE]
    a0, a1, a2 = taps[0]["weight"], taps[1]["weight"], taps[2]["weight"]
    a3, a4, a5 = taps[3]["weight"], taps[4]["weight"], taps[5]["weight"]
    a6, a7, a8 = taps[6]["weight"], taps[7]["weight"], taps[8]["weight"]
    for j in range(n):
        i = j + PAD
        top = w[j] + a0 * y[i - 1] + a1 * y[i] + a2 * y[i + 1]
        middle = top + a3 * y[i + STRIDE - 1] + a4 * y[i + STRIDE] + a5 * y[i + STRIDE + 1]
        drive = middle + a6 * y[i + 2 * STRIDE - 1] + a7 * y[i + 2 * STRIDE] + a8 * y[i + 2 * STRIDE + 1]
        out[j] = drive - x[j]


@helper
def _four_taps(
    out: Array, at_out: int, a: Array, at_a: int, b: Array, at_b: int, c: Array, at_c: int, d: Array, at_d: int, n: int,
    weights: tuple[float, float, float, float],
) -> None:  # fmt: skip
    """Add four weighted neighbours to each cell, one after the other as always, in one pass over the row."""
    out, a, b = out[at_out : at_out + n], a[at_a : at_a + n], b[at_b : at_b + n]
    c, d = c[at_c : at_c + n], d[at_d : at_d + n]
    wa, wb, wc, wd = weights
    for j in range(n):
        out[j] = out[j] + wa * a[j] + wb * b[j] + wc * c[j] + wd * d[j]


@helper
def _add(out: Array, at_out: int, weight: float, v: Array, at_v: int, n: int) -> None:
    """Add weight * v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] += weight * v[j]


@helper
def _sum(out: Array, at_out: int, x: Array, at_x: int, weight: float, v: Array, at_v: int, n: int) -> None:
    """Write x + weight * v."""
    out, x, v = out[at_out : at_out + n], x[at_x : at_x + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = x[j] + weight * v[j]


@helper
def _sum_onto(out: Array, at_out: int, x: Array, at_x: int, weight: float, n: int) -> None:
    """Replace what is there by x + weight times it."""
    out, x = out[at_out : at_out + n], x[at_x : at_x + n]
    for j in range(n):
        out[j] = x[j] + weight * out[j]


@helper
def _sum_and_output(
    out: Array, at_out: int, y: Array, at_y: int, x: Array, at_x: int, weight: float, v: Array, at_v: int, n: int
) -> None:
    """Write x + weight * v, and its output."""
    out, y, x, v = out[at_out : at_out + n], y[at_y : at_y + n], x[at_x : at_x + n], v[at_v : at_v + n]
    one = out.dtype.type(1)
    for j in range(n):
        s = x[j] + weight * v[j]
        out[j] = s
        y[j] = min_max(s, one)


@helper
def _copy(out: Array, at_out: int, v: Array, at_v: int, n: int) -> None:
    """Write v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = v[j]


@helper
def _output(y: Array, at_y: int, x: Array, at_x: int, n: int) -> None:
    """Write the output of x."""
    y, x = y[at_y : at_y + n], x[at_x : at_x + n]
    one = y.dtype.type(1)
    for j in range(n):
        y[j] = min_max(x[j], one)


@helper
def _less(out: Array, at_out: int, x: Array, at_x: int, n: int) -> None:
    """Subtract x."""
    out, x = out[at_out : at_out + n], x[at_x : at_x + n]
    for j in range(n):
        out[j] -= x[j]


@helper
def _where_held(out: Array, at_out: int, held: Array, at_held: int, v: Array, at_v: int, n: int) -> None:
    """Write v where cells are held."""
    out, held, v = out[at_out : at_out + n], held[at_held : at_held + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = v[j] if held[j] > 0 else out[j]


@helper
def _set_held(out: Array, at_out: int, held: Array, at_held: int, value: float, n: int) -> None:
    """Write a number where cells are held."""
    out, held = out[at_out : at_out + n], held[at_held : at_held + n]
    for j in range(n):
        out[j] = value if held[j] > 0 else out[j]


@helper
def _stop_at_limits(drive: Array, at_drive: int, x: Array, at_x: int, n: int) -> None:
    """Write x for drives that push a state against the limit that it is at."""
    drive, x = drive[at_drive : at_drive + n], x[at_x : at_x + n]
    one = x.dtype.type(1)
    for j in range(n):
        v, d = x[j], drive[j]
        drive[j] = v if ((v >= one) & (d > v)) | ((v <= -one) & (d < v)) else d


@helper
def _drives(scratch: Array, at_w: int, at_y: int, taps: Array, r: int, at_out: int, n: int) -> None:
    """Write w + A*y by any taps, where ``at_y`` is the row r above."""
    _copy(scratch, at_out, scratch, at_w, n)
    first, tap = at_y + r * STRIDE + PAD, 0
    while tap + 4 <= taps.size:
        a, b, c, d = taps[tap], taps[tap + 1], taps[tap + 2], taps[tap + 3]
        _four_taps(
            scratch, at_out, scratch, first + a["k"] * STRIDE + a["l"], scratch, first + b["k"] * STRIDE + b["l"],
            scratch, first + c["k"] * STRIDE + c["l"], scratch, first + d["k"] * STRIDE + d["l"], n,
            (a["weight"], b["weight"], c["weight"], d["weight"]),
        )  # fmt: skip
        tap += 4
    while tap < taps.size:
        a = taps[tap]
        _add(scratch, at_out, a["weight"], scratch, first + a["k"] * STRIDE + a["l"], n)
        tap += 1


@helper
def _go_on(scratch: Array, at_x: int, at_out: int, size: int, n: int, of: StageOf, o: int) -> None:
    """Go from the rates of a stage, in the row of scratch, to the next stage or to the end of the step."""
    s, count, rate, stage = of.stage, of.stages, of.at_row, of.at_stage + o
    weight, total = scratch[of.at_table + count * count + s], of.at_stage + size + o
    if s + 1 == count:
        if s > 0 and of.at_held == NOWHERE:
            _sum_and_output(scratch, at_x, scratch, at_out, scratch, total, weight, scratch, rate, n)
        else:  # x itself is needed until the end
            _sum_onto(scratch, rate, scratch, at_x if s == 0 else total, weight, n)
            if of.at_held != NOWHERE:
                _where_held(scratch, rate, scratch, of.at_held + o, scratch, at_x, n)
            _output(scratch, at_out, scratch, rate, n)
            _copy(scratch, at_x, scratch, rate, n)
        if of.limited:
            _copy(scratch, at_x, scratch, at_out, n)
        return
    if s == 0:
        _sum(scratch, total, scratch, at_x, weight, scratch, rate, n)
    else:
        _add(scratch, total, weight, scratch, rate, n)
    ahead = of.at_table + (s + 1) * count
    if of.keeps:
        kept = total + size
        _copy(scratch, kept + s * size, scratch, rate, n)
        _copy(scratch, stage, scratch, at_x, n)
        for earlier in range(s + 1):
            _add(scratch, stage, scratch[ahead + earlier], scratch, kept + earlier * size, n)
        _output(scratch, at_out, scratch, stage, n)
    else:
        _sum_and_output(scratch, stage, scratch, at_out, scratch, at_x, scratch[ahead + s], scratch, rate, n)
    if of.limited:
        _copy(scratch, stage, scratch, at_out, n)


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
            _drives(scratch, w, y, taps, r, out, n)
            if of.limited:
                _stop_at_limits(scratch, out, scratch, x, n)
            if of.at_held != NOWHERE:  # as what is saturated, which a check lets pass
                one = scratch.dtype.type(1)
                _set_held(scratch, out, scratch, of.at_held + o, one, n)
                _set_held(scratch, x, scratch, of.at_held + o, one, n)
            continue
        state = x if of.stage == 0 else of.at_stage + o
        if taps.size == 9 and r == 1:
            _nine_rates(scratch, of.at_row, scratch, w, scratch, y, scratch, state, taps, n)
        else:
            _drives(scratch, w, y, taps, r, of.at_row, n)
            _less(scratch, of.at_row, scratch, state, n)
        if of.at_held != NOWHERE:  # held in the stages, too: their neighbours see the stages
            _set_held(scratch, of.at_row, scratch, of.at_held + o, scratch.dtype.type(0), n)
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
