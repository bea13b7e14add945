"""What drives a cell without a time loop: w = B*u + z (+ bias map), row by row, the sums in the reference's order."""

from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.cpu.boundary import VirtualCells, cell, real_row, virtual_cells
from cnnsim.backends.cpu.compiled import call, compiled_at, helper, tap_type, twins
from cnnsim.network import ZERO_FLUX
from cnnsim.support import Array

FEW = 16
"""Rows that a thread does at a time."""


class Control(NamedTuple):
    """What w is made of, with `VirtualCells` of u: a ``bias`` that is not given has no cells; ``taps`` are records."""

    z: Any
    bias: Array
    u: Array
    taps: Array


@helper
def add_four(total: Array, rows: tuple[Array, Array, Array, Array], weights: tuple[float, float, float, float]) -> None:
    """Add four weighted neighbours to each cell, one after the other as always, in one pass over the row."""
    a, b, d, e = rows
    wa, wb, wd, we = weights
    for j in range(total.size):
        total[j] = total[j] + wa * a[j] + wb * b[j] + wd * d[j] + we * e[j]


@helper
def control_row(total: Array, u: Array, i: int, taps: Array, virtual: VirtualCells) -> None:
    """Add B*u of row i of one grid."""
    n, tap, r = total.size, 0, virtual[2]
    inside = n > 2 * r
    for each in range(taps.size):
        inside &= real_row(i + taps[each]["k"], virtual) >= 0
    while tap < taps.size:
        if inside and tap + 4 <= taps.size:
            one, two, three, four = taps[tap], taps[tap + 1], taps[tap + 2], taps[tap + 3]
            a, b = u[real_row(i + one["k"], virtual)], u[real_row(i + two["k"], virtual)]
            d, e = u[real_row(i + three["k"], virtual)], u[real_row(i + four["k"], virtual)]
            add_four(
                total[r : n - r], (a[r + one["l"] :], b[r + two["l"] :], d[r + three["l"] :], e[r + four["l"] :]),
                (one["weight"], two["weight"], three["weight"], four["weight"]),
            )  # fmt: skip
            for t in range(tap, tap + 4):
                for j in range(2 * r):
                    column = j if j < r else n - 2 * r + j
                    value = cell(u, i + taps[t]["k"], column + taps[t]["l"], virtual)
                    total[column] += taps[t]["weight"] * value
            tap += 4
            continue
        k, l, c = taps[tap]["k"], taps[tap]["l"], taps[tap]["weight"]
        p, first, last = real_row(i + k, virtual), n, n
        if p >= 0:
            first, last = min(max(-l, 0), n), max(min(n - l, n), 0)
        for j in range(first):
            total[j] += c * cell(u, i + k, j + l, virtual)
        if last > first:
            inner, values = total[first:last], u[p, first + l : last + l]
            for j in range(inner.size):
                inner[j] += c * values[j]
        for j in range(max(last, first), n):
            total[j] += c * cell(u, i + k, j + l, virtual)
        tap += 1


def control_rows(w: Array, control: Control, virtual: VirtualCells, first: int, after: int) -> None:
    """Write z + bias + B*u into some rows of w, counted through all grids."""
    z, bias, u, taps = control
    height, width = w.shape[1:]
    for line in range(first, after):
        g, i = line // height, line % height
        total = w[g, i]
        if bias.size:  # which may lie where w goes
            for j in range(width):
                total[j] = z + bias[g, i, j]
        else:
            for j in range(width):
                total[j] = z
        control_row(total, u[g], i, taps, virtual)


@cache
def controlling(dtype: np.dtype[Any]) -> Any:
    """Return `control_rows` compiled for a dtype."""
    plane, zero = np.empty((1, 1, 1), dtype), dtype.type(0)
    control = tuple(Control(zero, plane, plane, np.empty(0, tap_type(dtype))))
    groups = map(numba.typeof, (plane, control, virtual_cells((1, 1), 0, ZERO_FLUX, zero)))
    return compiled_at(control_rows, types.void(*groups, types.int64, types.int64))


@twins
def control(rows_at: int, w: Array, given: Control, virtual: VirtualCells, first: int, after: int) -> None:
    """Write z + bias + B*u into the rows of w from ``first`` on; ``rows_at`` is the address of `control_rows`."""
    for few in prange((after - first + FEW - 1) // FEW):
        call(rows_at, (w, given, virtual, first + few * FEW, min(after, first + (few + 1) * FEW)))
