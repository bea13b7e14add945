"""The constant part of the drive, w = B*u + z (+ bias map), row by row, summed in the reference's order."""

from typing import Any, NamedTuple

from numba import prange

from cnnsim.backends.cpu.boundary import VirtualCells, cell, real_row
from cnnsim.backends.cpu.compiled import helper, twins, uncounted
from cnnsim.support import Array


class Control(NamedTuple):
    """Parts of w, with `VirtualCells` of u; without a bias map ``bias`` has no cells; ``taps`` are records."""

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


@twins
def control(w: Array, given: Control, virtual: VirtualCells, first: int, after: int) -> None:
    """Write z + bias + B*u into rows of w, which are counted through all grids."""
    z, bias, u, taps = given
    height, width = w.shape[1:]
    for line in prange(first, after):
        g, i = line // height, line % height
        total, inputs = uncounted(w)[g, i], uncounted(u)[g]
        if bias.size:  # which may lie in w
            for j in range(width):
                total[j] = z + bias[g, i, j]
        else:
            for j in range(width):
                total[j] = z
        control_row(total, inputs, i, uncounted(taps), virtual)
