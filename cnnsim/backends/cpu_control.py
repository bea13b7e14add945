"""w = B*u + z (+ bias map), computed once: row by row, the sums in the reference's order."""

from typing import Any

from numba import prange
from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import helper, twins

Array = NDArray[Any]


@helper
def control_row(
    total: Array, u: Array, i: int, k: Array, l: Array, weight: Array, rows: Array, cols: Array, r: int, constant: float
) -> None:
    """Add B*u of row i of one grid; ``rows``, ``cols``: which real cell a position stands for (-1: a constant)."""
    n = total.size
    for tap in range(weight.size):
        c, p = weight[tap], rows[i + r + k[tap]]
        if p < 0:
            for j in range(n):
                total[j] += c * constant
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


@twins
def control(
    w: Array, z: float, bias: Array, u: Array, k: Array, l: Array, weight: Array, rows: Array, cols: Array, r: int,
    constant: float,
) -> None:  # fmt: skip
    """Write z + bias + B*u into w; a bias that is not given has no cells."""
    n, height, width = w.shape
    for line in prange(n * height):
        g, i = line // height, line % height
        total = w[g, i]
        for j in range(width):
            total[j] = z
        if bias.size:
            for j in range(width):
                total[j] += bias[g, i, j]
        control_row(total, u[g], i, k, l, weight, rows, cols, r, constant)
