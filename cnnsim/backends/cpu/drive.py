"""w = B*u + z (+ bias map), computed once: row by row, the sums in the reference's order."""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.cpu.jit.address import call, compiled_at
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.support import Array

FEW = 16
"""Rows that a thread does at a time."""


@helper
def add_four(total: Array, a: Array, b: Array, d: Array, e: Array, wa: float, wb: float, wd: float, we: float) -> None:
    """Add four weighted neighbours to each cell, one after the other as always, in one pass over the row."""
    for j in range(total.size):
        total[j] = total[j] + wa * a[j] + wb * b[j] + wd * d[j] + we * e[j]


@helper
def control_row(
    total: Array, u: Array, i: int, k: Array, l: Array, weight: Array, rows: Array, cols: Array, r: int, constant: float
) -> None:
    """Add B*u of row i of one grid; ``rows``, ``cols``: which real cell a position stands for (-1: a constant)."""
    n, tap = total.size, 0
    inside = n > 2 * r
    for each in range(weight.size):
        inside &= rows[i + r + k[each]] >= 0
    while tap < weight.size:
        if inside and tap + 4 <= weight.size:
            t = tap + 1, tap + 2, tap + 3
            a, b = u[rows[i + r + k[tap]]], u[rows[i + r + k[t[0]]]]
            d, e = u[rows[i + r + k[t[1]]]], u[rows[i + r + k[t[2]]]]
            add_four(
                total[r : n - r], a[r + l[tap] :], b[r + l[t[0]] :], d[r + l[t[1]] :], e[r + l[t[2]] :],
                weight[tap], weight[t[0]], weight[t[1]], weight[t[2]],
            )  # fmt: skip
            for four in range(tap, tap + 4):
                line = u[rows[i + r + k[four]]]
                for j in range(2 * r):
                    column = j if j < r else n - 2 * r + j
                    at = cols[column + r + l[four]]
                    total[column] += weight[four] * (constant if at < 0 else line[at])
            tap += 4
            continue
        c, p = weight[tap], rows[i + r + k[tap]]
        if p < 0:
            for j in range(n):
                total[j] += c * constant
            tap += 1
            continue
        line, shift = u[p], l[tap]
        first, last = min(max(-shift, 0), n), max(min(n - shift, n), 0)
        for j in range(first):
            at = cols[j + r + shift]
            total[j] += c * (constant if at < 0 else line[at])
        if last > first:
            inner, seen = total[first:last], line[first + shift : last + shift]
            for j in range(inner.size):
                inner[j] += c * seen[j]
        for j in range(max(last, first), n):
            at = cols[j + r + shift]
            total[j] += c * (constant if at < 0 else line[at])
        tap += 1


def control_rows(
    w: Array, z: float, bias: Array, u: Array, k: Array, l: Array, weight: Array, rows: Array, cols: Array, r: int,
    constant: float, first: int, after: int,
) -> None:  # fmt: skip
    """Write z + bias + B*u into some rows of w, counted through all grids; a bias that is not given has no cells."""
    height, width = w.shape[1:]
    for line in range(first, after):
        g, i = line // height, line % height
        total = w[g, i]
        for j in range(width):
            total[j] = z
        if bias.size:
            for j in range(width):
                total[j] += bias[g, i, j]
        control_row(total, u[g], i, k, l, weight, rows, cols, r, constant)


@cache
def controlling(dtype: np.dtype[Any]) -> Any:
    """Return `control_rows` compiled for a dtype."""
    cells, integer, whole = numba.from_dtype(dtype), types.int64, types.int64[::1]
    planes, row = types.Array(cells, 3, "C"), types.Array(cells, 1, "C")
    return compiled_at(
        control_rows,
        types.void(planes, cells, planes, planes, whole, whole, row, whole, whole, integer, cells, integer, integer),
    )


@twins
def control(
    rows_at: int, w: Array, z: float, bias: Array, u: Array, k: Array, l: Array, weight: Array, rows: Array,
    cols: Array, r: int, constant: float,
) -> None:  # fmt: skip
    """Write z + bias + B*u into w; ``rows_at`` is the address of `control_rows`."""
    lines = w.shape[0] * w.shape[1]
    for few in prange((lines + FEW - 1) // FEW):
        call(rows_at, (w, z, bias, u, k, l, weight, rows, cols, r, constant, few * FEW, min(lines, (few + 1) * FEW)))
