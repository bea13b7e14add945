"""One Euler step of a block of rows, its data in the first-level cache: the innermost loops of the CPU backend.

All arrays are flat, row q of a block begins at q * STRIDE. With a stride known to the compiler, all rows of one array
are one memory range to it, so that few checks for overlap are left and the loops become vector code. Rows of outputs
``y`` begin PAD cells before their first column, which is room for the virtual cells on the left.

    total = w + sum of the taps in their order,    x <- x + h (total - x),    new y = clip(x, -1, 1)
"""

from typing import Any

from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import fused, helper

Array = NDArray[Any]

BLOCK = 4
"""Rows done together: each row of y is loaded once for all the rows it is a neighbour of."""
STRIDE = 1104
"""Cells from row to row: no multiple of 1024, so that the rows of a block do not fight for cache sets."""
PAD = 16
"""One vector of float32: the first real column of y is aligned where x and w are."""


@fused
def nine_taps(x: Array, w: Array, y: Array, out: Array, n: int, a: Array, h: float) -> None:
    """Step a block by a 3 x 3 matrix whose nine entries are ``a``."""
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]
    one = x.dtype.type(1)
    for j in range(n):
        for q in range(BLOCK):
            i = q * STRIDE + j
            total = w[i] + a0 * y[i + PAD - 1]
            total += a1 * y[i + PAD]
            total += a2 * y[i + PAD + 1]
            total += a3 * y[i + STRIDE + PAD - 1]
            total += a4 * y[i + STRIDE + PAD]
            total += a5 * y[i + STRIDE + PAD + 1]
            total += a6 * y[i + 2 * STRIDE + PAD - 1]
            total += a7 * y[i + 2 * STRIDE + PAD]
            total += a8 * y[i + 2 * STRIDE + PAD + 1]
            v = x[i]
            v += h * (total - v)
            x[i] = v
            v = one if v > one else v
            out[i + PAD] = -one if v < -one else v


@fused
def cross(x: Array, w: Array, y: Array, out: Array, n: int, a: Array, h: float) -> None:
    """Step a block by a 3 x 3 matrix with nothing in its corners."""
    a1, a3, a4, a5, a7 = a[1], a[3], a[4], a[5], a[7]
    one = x.dtype.type(1)
    for j in range(n):
        for q in range(BLOCK):
            i = q * STRIDE + j
            total = w[i] + a1 * y[i + PAD]
            total += a3 * y[i + STRIDE + PAD - 1]
            total += a4 * y[i + STRIDE + PAD]
            total += a5 * y[i + STRIDE + PAD + 1]
            total += a7 * y[i + 2 * STRIDE + PAD]
            v = x[i]
            v += h * (total - v)
            x[i] = v
            v = one if v > one else v
            out[i + PAD] = -one if v < -one else v


@fused
def isotropic(x: Array, w: Array, y: Array, out: Array, n: int, a: Array, h: float) -> None:
    """Step a block by a 3 x 3 matrix with one number in its corners and one on its edges: neighbours add up first."""
    corner, edge, centre = a[0], a[1], a[4]
    one = x.dtype.type(1)
    for j in range(n):
        for q in range(BLOCK):
            i = q * STRIDE + j
            above = y[i + PAD - 1] + y[i + PAD + 1]
            beside = y[i + STRIDE + PAD - 1] + y[i + STRIDE + PAD + 1]
            below = y[i + 2 * STRIDE + PAD - 1] + y[i + 2 * STRIDE + PAD + 1]
            total = w[i] + centre * y[i + STRIDE + PAD]
            total += edge * (beside + (y[i + PAD] + y[i + 2 * STRIDE + PAD]))
            total += corner * (above + below)
            v = x[i]
            v += h * (total - v)
            x[i] = v
            v = one if v > one else v
            out[i + PAD] = -one if v < -one else v


def _drive_row(w: Array, y: Array, q: int, k: Array, l: Array, weight: Array, r: int, total: Array) -> None:
    """Write w + A*y of row q of a block into ``total``."""
    row = w[q * STRIDE : q * STRIDE + total.size]
    for j in range(total.size):
        total[j] = row[j]
    for tap in range(weight.size):
        first = (q + r + k[tap]) * STRIDE + PAD + l[tap]
        line = y[first : first + total.size]
        c = weight[tap]
        for j in range(total.size):
            total[j] += c * line[j]


def _finish_row(x: Array, total: Array, out: Array, h: float) -> None:
    """Go from A*y + w to the new state and its output."""
    one = x.dtype.type(1)
    for j in range(total.size):
        x[j] += h * (total[j] - x[j])
    for j in range(total.size):
        v = x[j]
        v = one if v > one else v
        out[j] = -one if v < -one else v


drive_row_fused = fused(_drive_row)
finish_row_fused = fused(_finish_row)
drive_row_exact = helper(_drive_row)
finish_row_exact = helper(_finish_row)


@helper
def drive_row(w: Array, y: Array, q: int, k: Array, l: Array, weight: Array, r: int, total: Array) -> None:
    """Write w + A*y of row q: in float64 rounded like the reference, in float32 with FMA."""
    if w.itemsize == 4:
        drive_row_fused(w, y, q, k, l, weight, r, total)
    else:
        drive_row_exact(w, y, q, k, l, weight, r, total)


@helper
def any_taps(
    x: Array, w: Array, y: Array, out: Array, n: int, k: Array, l: Array, weight: Array, r: int, h: float, total: Array
) -> None:
    """Step a block by any list of taps of radius r; ``total`` is room for a row."""
    for q in range(BLOCK):
        drive_row(w, y, q, k, l, weight, r, total[:n])
        row, new = x[q * STRIDE : q * STRIDE + n], out[q * STRIDE + PAD : q * STRIDE + PAD + n]
        if x.itemsize == 4:
            finish_row_fused(row, total[:n], new, h)
        else:
            finish_row_exact(row, total[:n], new, h)
