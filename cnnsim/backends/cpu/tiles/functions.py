"""Functions of rows of cells: tables, clip, sign and tanh.

Every loop runs along one row without branches, so that it becomes vector code. A table is a chain of comparisons: each
keeps the value so far or replaces it, four places a pass. See `term_table.Function` for kinds, places and values.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numba import carray, types

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.compiled import call, compiled_at, helper, pointer, pointer_type
from cnnsim.support import Array

IDENTITY, LINEAR, _, CLIP, SIGN, TANH = map(int, FunctionCode)


@helper
def min_max(v: float, one: float) -> float:
    """Return clip(v, -1, 1); NaN stays NaN."""
    v = one if v > one else v
    return -one if v < -one else v


@helper
def copy_row(out: Array, v: Array) -> None:
    """Write v. A loop: an assignment of slices checks for overlap, which costs ten times as much."""
    for j in range(out.size):
        out[j] = v[j]


@helper
def fill(cells: Array, value: Any) -> None:
    """Set cells to a value."""
    for j in range(cells.size):
        cells[j] = value


@helper
def clip_row(out: Array, v: Array, slope: float) -> None:
    """Write clip(slope * v, -1, 1)."""
    one = v.dtype.type(1)
    for j in range(out.size):
        out[j] = min_max(v[j] * slope, one)


@helper
def step_beyond(at: Array, values: Array, s: int) -> Any:
    """Return place s and the value beyond it; NaN, which nothing exceeds, if there is no such place."""
    if s >= at.size:
        return values.dtype.type(math.nan), values.dtype.type(0)
    return at[s], values[s + 1]


@helper
def line_from(at: Array, values: Array, s: int) -> Any:
    """Return place s, the value there and the slope from there; NaN, which nothing exceeds, if no line begins there."""
    zero = values.dtype.type(0)
    if s >= at.size - 1:
        return values.dtype.type(math.nan), zero, zero
    return at[s], values[s], (values[s + 1] - values[s]) / (at[s + 1] - at[s])


@helper
def _four_steps(out: Array, v: Array, fresh: bool, start: float, edges: Any, heights: Any) -> None:
    """Replace the values (``fresh``: start) by the heights where v exceeds the edges, which increase."""
    (e0, e1, e2, e3), (f0, f1, f2, f3) = edges, heights
    for j in range(out.size):
        p, f = v[j], start if fresh else out[j]
        f = f0 if p > e0 else f
        f = f1 if p > e1 else f
        f = f2 if p > e2 else f
        out[j] = f3 if p > e3 else f


@helper
def _steps_row(out: Array, v: Array, at: Array, values: Array) -> None:
    for s in range(0, max(at.size, 1), 4):
        e0, f0 = step_beyond(at, values, s)
        e1, f1 = step_beyond(at, values, s + 1)
        e2, f2 = step_beyond(at, values, s + 2)
        e3, f3 = step_beyond(at, values, s + 3)
        _four_steps(out, v, s == 0, values[0], (e0, e1, e2, e3), (f0, f1, f2, f3))


@helper
def _four_lines(out: Array, v: Array, fresh: bool, edges: Any, heights: Any, slopes: Any, ends: Any) -> None:
    """Replace the values (``fresh``: the first end) by lines where v exceeds their edges; beyond the last place by the
    second end.
    """
    (e0, e1, e2, e3), (f0, f1, f2, f3), (r0, r1, r2, r3), (start, last, end) = edges, heights, slopes, ends
    for j in range(out.size):
        p, f = v[j], start if fresh else out[j]
        f = f0 + r0 * (p - e0) if p > e0 else f
        f = f1 + r1 * (p - e1) if p > e1 else f
        f = f2 + r2 * (p - e2) if p > e2 else f
        f = f3 + r3 * (p - e3) if p > e3 else f
        out[j] = end if p > last else f


@helper
def _lines_row(out: Array, v: Array, at: Array, values: Array) -> None:
    lines = at.size - 1
    ends = values[0], at[lines], values[lines]
    for s in range(0, max(lines, 1), 4):
        e0, f0, r0 = line_from(at, values, s)
        e1, f1, r1 = line_from(at, values, s + 1)
        e2, f2, r2 = line_from(at, values, s + 2)
        e3, f3, r3 = line_from(at, values, s + 3)
        _four_lines(out, v, s == 0, (e0, e1, e2, e3), (f0, f1, f2, f3), (r0, r1, r2, r3), ends)


@helper
def _sign_row(out: Array, v: Array) -> None:
    zero, one = v.dtype.type(0), v.dtype.type(1)
    for j in range(out.size):
        p = one if v[j] > zero else v[j]
        out[j] = -one if p < zero else p


@helper
def _tanh_row(out: Array, v: Array, slope: float) -> None:
    for j in range(out.size):
        out[j] = math.tanh(v[j] * slope)


@helper
def _tanh_row_single(out: Array, v: Array, slope: float) -> None:
    """Write tanh within 2e-7 without a call: Lambert's fraction at a quarter of the argument, doubled twice."""
    top, quarter, one = np.float32(9.2), np.float32(0.25), np.float32(1)
    a0, a1, a2 = np.float32(135135), np.float32(17325), np.float32(378)
    b1, b2, b3 = np.float32(62370), np.float32(3150), np.float32(28)
    for j in range(out.size):
        p = v[j] * slope
        p = top if p > top else p  # tanh is 1 in single precision from here on
        p = (-top if p < -top else p) * quarter
        q = p * p
        t = p * (((q + a2) * q + a1) * q + a0) / (((b3 * q + b2) * q + b1) * q + a0)
        t = (t + t) / (one + t * t)
        t = (t + t) / (one + t * t)
        out[j] = one if t > one else -one if t < -one else t


def _function_row(out: Any, v: Any, n: int, kind: int, places: int, numbers: Any, values: Any) -> None:
    out, v = carray(out, (n,)), carray(v, (n,))
    at, values = carray(numbers, (places,)), carray(values, (places + 1,))
    if kind == IDENTITY:
        copy_row(out, v)
    elif kind == SIGN:
        _sign_row(out, v)
    elif kind == TANH:
        if at.itemsize == 4:
            _tanh_row_single(out, v, at[0])
        else:
            _tanh_row(out, v, at[0])
    elif kind == LINEAR:
        _lines_row(out, v, at, values)
    else:
        _steps_row(out, v, at, values)


@cache
def functions(dtype: np.dtype[Any]) -> Any:
    """Return the function that `function_row` calls, compiled for a dtype."""
    cells, integer = pointer_type(dtype), types.int64
    return compiled_at(_function_row, types.void(cells, cells, integer, integer, integer, cells, cells))


@helper
def function_row(address: int, out: Array, v: Array, kind: int, places: int, at: Array, values: Array) -> None:
    """Write a function of the row v into another row.

    ``address`` is that of `functions`: all kinds together take long to compile. The places begin in ``at``.
    """
    if kind == CLIP:
        clip_row(out, v, at[0])
        return
    call(address, (pointer(out), pointer(v), out.size, kind, places, pointer(at), pointer(values)))
