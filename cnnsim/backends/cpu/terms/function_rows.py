"""Functions of rows of cells: tables, clip, sign and tanh, a vector of cells at a time.

Every loop runs along one row and is free of branches, so that it becomes vector code: a table is a chain of comparisons
that each keep the value or replace it, a step after a step. Rows are given as a flat array and where they begin.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numba import carray, types

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.jit.address import call, compiled_at, pointer, pointer_type
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array

IDENTITY, LINEAR, _, CLIP, SIGN, TANH = map(int, FunctionCode)


@helper
def copy_row(out: Array, at_out: int, v: Array, at_v: int, n: int) -> None:
    """Write v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = v[j]


@helper
def _four_steps(
    out: Array, at_out: int, v: Array, at_v: int, n: int, fresh: bool, start: float, e0: float, e1: float, e2: float,
    e3: float, f0: float, f1: float, f2: float, f3: float,
) -> None:  # fmt: skip
    """Replace what is there (``fresh``: start) by f0 .. f3 where v is beyond e0 .. e3, which grow."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        p, f = v[j], start if fresh else out[j]
        f = f0 if p > e0 else f
        f = f1 if p > e1 else f
        f = f2 if p > e2 else f
        out[j] = f3 if p > e3 else f


@helper
def _four_lines(
    out: Array, at_out: int, v: Array, at_v: int, n: int, fresh: bool, start: float, e0: float, e1: float, e2: float,
    e3: float, f0: float, f1: float, f2: float, f3: float, r0: float, r1: float, r2: float, r3: float, last: float,
    end: float,
) -> None:  # fmt: skip
    """Replace what is there (``fresh``: start) by f0 + r0 (v - e0) where v is beyond e0, and so on; by ``end`` beyond
    ``last``, the place after all others.
    """
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        p, f = v[j], start if fresh else out[j]
        f = f0 + r0 * (p - e0) if p > e0 else f
        f = f1 + r1 * (p - e1) if p > e1 else f
        f = f2 + r2 * (p - e2) if p > e2 else f
        f = f3 + r3 * (p - e3) if p > e3 else f
        out[j] = end if p > last else f


@helper
def step_beyond(places: int, at: int, values: int, s: int, numbers: Array) -> Any:
    """Return place s and the value beyond it; NaN, beyond which nothing is, if there is none."""
    if s >= places:
        return numbers.dtype.type(math.nan), numbers.dtype.type(0)
    return numbers[at + s], numbers[values + s + 1]


@helper
def line_from(lines: int, at: int, values: int, s: int, numbers: Array) -> Any:
    """Return place s, the value there and the slope from there on; NaN, beyond which nothing is, if there is none."""
    zero = numbers.dtype.type(0)
    if s >= lines:
        return numbers.dtype.type(math.nan), zero, zero
    e, f = numbers[at + s], numbers[values + s]
    return e, f, (numbers[values + s + 1] - f) / (numbers[at + s + 1] - e)


@helper
def _steps_row(
    out: Array, at_out: int, v: Array, at_v: int, n: int, places: int, at: int, values: int, numbers: Array
) -> None:
    for s in range(0, max(places, 1), 4):
        e0, f0 = step_beyond(places, at, values, s, numbers)
        e1, f1 = step_beyond(places, at, values, s + 1, numbers)
        e2, f2 = step_beyond(places, at, values, s + 2, numbers)
        e3, f3 = step_beyond(places, at, values, s + 3, numbers)
        _four_steps(out, at_out, v, at_v, n, s == 0, numbers[values], e0, e1, e2, e3, f0, f1, f2, f3)


@helper
def _lines_row(
    out: Array, at_out: int, v: Array, at_v: int, n: int, places: int, at: int, values: int, numbers: Array
) -> None:
    lines = places - 1  # beyond the last place is none
    for s in range(0, max(lines, 1), 4):
        e0, f0, r0 = line_from(lines, at, values, s, numbers)
        e1, f1, r1 = line_from(lines, at, values, s + 1, numbers)
        e2, f2, r2 = line_from(lines, at, values, s + 2, numbers)
        e3, f3, r3 = line_from(lines, at, values, s + 3, numbers)
        _four_lines(out, at_out, v, at_v, n, s == 0, numbers[values], e0, e1, e2, e3, f0, f1, f2, f3, r0, r1, r2, r3,
                    numbers[at + lines], numbers[values + lines])  # fmt: skip


@helper
def _clip_row(out: Array, at_out: int, v: Array, at_v: int, n: int, slope: float) -> None:
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    one = v.dtype.type(1)
    for j in range(n):
        p = v[j] * slope
        p = one if p > one else p
        out[j] = -one if p < -one else p


@helper
def _sign_row(out: Array, at_out: int, v: Array, at_v: int, n: int) -> None:
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    zero, one = v.dtype.type(0), v.dtype.type(1)
    for j in range(n):
        p = one if v[j] > zero else v[j]
        out[j] = -one if p < zero else p


@helper
def _tanh_row(out: Array, at_out: int, v: Array, at_v: int, n: int, slope: float) -> None:
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = math.tanh(v[j] * slope)


@helper
def _tanh_row_single(out: Array, at_out: int, v: Array, at_v: int, n: int, slope: float) -> None:
    """Write tanh within 2e-7 without a call: Lambert's fraction at a quarter of the argument, doubled twice."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    top, quarter, one = np.float32(9.2), np.float32(0.25), np.float32(1)
    a0, a1, a2 = np.float32(135135), np.float32(17325), np.float32(378)
    b1, b2, b3 = np.float32(62370), np.float32(3150), np.float32(28)
    for j in range(n):
        p = v[j] * slope
        p = top if p > top else p  # tanh is 1 in single precision from here on
        p = (-top if p < -top else p) * quarter
        q = p * p
        t = p * (((q + a2) * q + a1) * q + a0) / (((b3 * q + b2) * q + b1) * q + a0)
        t = (t + t) / (one + t * t)
        t = (t + t) / (one + t * t)
        out[j] = one if t > one else -one if t < -one else t


@helper
def _function_row(
    out: Array, at_out: int, v: Array, at_v: int, n: int, kind: int, places: int, at: int, values: int, numbers: Array
) -> None:
    """Write a function of a row, which must be another one; see `term_table.Function`."""
    if kind == IDENTITY:
        copy_row(out, at_out, v, at_v, n)
    elif kind == CLIP:
        _clip_row(out, at_out, v, at_v, n, numbers[at])
    elif kind == SIGN:
        _sign_row(out, at_out, v, at_v, n)
    elif kind == TANH:
        if numbers.itemsize == 4:
            _tanh_row_single(out, at_out, v, at_v, n, numbers[at])
        else:
            _tanh_row(out, at_out, v, at_v, n, numbers[at])
    elif kind == LINEAR:
        _lines_row(out, at_out, v, at_v, n, places, at, values, numbers)
    else:
        _steps_row(out, at_out, v, at_v, n, places, at, values, numbers)


def _function_row_at(
    out: Any, at_out: int, v: Any, at_v: int, n: int, kind: int, places: int, at: int, values: int, numbers: Any
) -> None:
    _function_row(carray(out, (at_out + n,)), at_out, carray(v, (at_v + n,)), at_v, n, kind, places, at, values,
                  carray(numbers, (values + places + 1,)))  # fmt: skip


@cache
def functions(dtype: np.dtype[Any]) -> Any:
    """Return what `function_row` calls, compiled for a dtype."""
    cells, integer = pointer_type(dtype), types.int64
    return compiled_at(_function_row_at, types.void(cells, integer, cells, integer, *5 * [integer], cells))


@helper
def function_row(
    function: int, out: Array, at_out: int, v: Array, at_v: int, n: int, kind: int, places: int, at: int, values: int,
    numbers: Array,
) -> None:  # fmt: skip
    """Write a function of a row by what lies at an address, `functions`: all kinds are long to compile."""
    call(function, (pointer(out), at_out, pointer(v), at_v, n, kind, places, at, values, pointer(numbers)))
