"""One Euler step of a block of rows, its data in the first-level cache: the innermost loops of the CPU backend.

Everything lies in one flat array, ``room``; x, w, y and ``out`` say where a block begins, and row q of it begins at
q * STRIDE. With a stride known to the compiler, all rows of a block are one memory range to it, so that few checks for
overlap are left and the loops become vector code. One array, because every slice that is handed to another function
costs two atomic instructions for its reference count; it is handed over once for each of its uses, because parts of
one array are not checked for overlap but taken to overlap. Rows of outputs ``y`` begin PAD cells before their first
column, which is room for the virtual cells on the left.

    total = w + sum of the taps in their order,    x <- x + h (total - x),    new y = clip(x, -1, 1)
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import fused, helper

Array = NDArray[Any]

BLOCK = 4
"""Rows done together: each row of y is loaded once for all the rows it is a neighbour of."""
STRIDE = 1104
"""Cells from row to row: no multiple of 1024, so that the rows of a block do not fight for cache sets."""
PAD = 16
"""One vector of float32: the first real column of y is aligned where x and w are."""


@helper
def min_max(v: float, one: float) -> float:
    """Return clip(v, -1, 1); NaN stays NaN."""
    v = one if v > one else v
    return -one if v < -one else v


@fused
def nine_taps(
    x: Array, at_x: int, w: Array, at_w: int, y: Array, at_y: int, out: Array, at_out: int, n: int, a: Array, at_a: int,
    h: float,
) -> None:  # fmt: skip
    """Step a block by a 3 x 3 matrix whose nine entries begin at ``at_a``."""
    x, w, a = x[at_x : at_x + BLOCK * STRIDE], w[at_w : at_w + BLOCK * STRIDE], a[at_a : at_a + 9]
    y, out = y[at_y : at_y + (BLOCK + 2) * STRIDE], out[at_out : at_out + BLOCK * STRIDE]
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
            out[i + PAD] = min_max(v, one)


@fused
def cross(
    x: Array, at_x: int, w: Array, at_w: int, y: Array, at_y: int, out: Array, at_out: int, n: int, a: Array, at_a: int,
    h: float,
) -> None:  # fmt: skip
    """Step a block by a 3 x 3 matrix with nothing in its corners."""
    x, w, a = x[at_x : at_x + BLOCK * STRIDE], w[at_w : at_w + BLOCK * STRIDE], a[at_a : at_a + 9]
    y, out = y[at_y : at_y + (BLOCK + 2) * STRIDE], out[at_out : at_out + BLOCK * STRIDE]
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
            out[i + PAD] = min_max(v, one)


@fused
def isotropic(
    x: Array, at_x: int, w: Array, at_w: int, y: Array, at_y: int, out: Array, at_out: int, n: int, a: Array, at_a: int,
    h: float,
) -> None:  # fmt: skip
    """Step a block by a 3 x 3 matrix with one number in its corners and one on its edges: neighbours add up first."""
    x, w, a = x[at_x : at_x + BLOCK * STRIDE], w[at_w : at_w + BLOCK * STRIDE], a[at_a : at_a + 9]
    y, out = y[at_y : at_y + (BLOCK + 2) * STRIDE], out[at_out : at_out + BLOCK * STRIDE]
    corner, edge, centre = a[0], a[1], a[4]
    one = x.dtype.type(1)
    for j in range(n):  # written out for the block's four rows, so that sums are shared between them
        i = j + PAD
        y0, y1, y2 = y[i], y[i + STRIDE], y[i + 2 * STRIDE]
        y3, y4, y5 = y[i + 3 * STRIDE], y[i + 4 * STRIDE], y[i + 5 * STRIDE]
        s0 = y[i - 1] + y[i + 1]
        s1 = y[i + STRIDE - 1] + y[i + STRIDE + 1]
        s2 = y[i + 2 * STRIDE - 1] + y[i + 2 * STRIDE + 1]
        s3 = y[i + 3 * STRIDE - 1] + y[i + 3 * STRIDE + 1]
        s4 = y[i + 4 * STRIDE - 1] + y[i + 4 * STRIDE + 1]
        s5 = y[i + 5 * STRIDE - 1] + y[i + 5 * STRIDE + 1]
        t0 = ((w[j] + centre * y1) + edge * (s1 + (y0 + y2))) + corner * (s0 + s2)
        t1 = ((w[j + STRIDE] + centre * y2) + edge * (s2 + (y1 + y3))) + corner * (s1 + s3)
        t2 = ((w[j + 2 * STRIDE] + centre * y3) + edge * (s3 + (y2 + y4))) + corner * (s2 + s4)
        t3 = ((w[j + 3 * STRIDE] + centre * y4) + edge * (s4 + (y3 + y5))) + corner * (s3 + s5)
        x0, x1, x2, x3 = x[j], x[j + STRIDE], x[j + 2 * STRIDE], x[j + 3 * STRIDE]
        x0 += h * (t0 - x0)
        x1 += h * (t1 - x1)
        x2 += h * (t2 - x2)
        x3 += h * (t3 - x3)
        x[j], x[j + STRIDE], x[j + 2 * STRIDE], x[j + 3 * STRIDE] = x0, x1, x2, x3
        out[i] = min_max(x0, one)
        out[i + STRIDE] = min_max(x1, one)
        out[i + 2 * STRIDE] = min_max(x2, one)
        out[i + 3 * STRIDE] = min_max(x3, one)


def _drive_row(
    room: Array, at_w: int, at_y: int, k: Array, l: Array, weight: Array, r: int, at_total: int, n: int
) -> None:
    """Write w + A*y of one row, where ``at_y`` is the row r above it."""
    total, row = room[at_total : at_total + n], room[at_w : at_w + n]
    for j in range(n):
        total[j] = row[j]
    for tap in range(weight.size):
        first = at_y + (r + k[tap]) * STRIDE + PAD + l[tap]
        line = room[first : first + n]
        c = weight[tap]
        for j in range(n):
            total[j] += c * line[j]


def _finish_row(room: Array, at_x: int, at_total: int, at_out: int, n: int, h: float) -> None:
    """Go from A*y + w to the new state and its output."""
    x, total, out = room[at_x : at_x + n], room[at_total : at_total + n], room[at_out : at_out + n]
    one = room.dtype.type(1)
    for j in range(n):
        x[j] += h * (total[j] - x[j])
    for j in range(n):
        out[j] = min_max(x[j], one)


drive_row_fused, finish_row_fused = fused(_drive_row), fused(_finish_row)
drive_row_exact, finish_row_exact = helper(_drive_row), helper(_finish_row)


@helper
def any_taps(
    room: Array, at_x: int, at_w: int, at_y: int, at_out: int, n: int, k: Array, l: Array, weight: Array, r: int,
    at_row: int, h: float,
) -> None:  # fmt: skip
    """Step a block by any taps of radius r; in float64 rounded like the reference, in float32 with FMA."""
    for q in range(BLOCK):
        o = q * STRIDE
        if room.itemsize == 4:
            drive_row_fused(room, at_w + o, at_y + o, k, l, weight, r, at_row, n)
            finish_row_fused(room, at_x + o, at_row, at_out + o + PAD, n, h)
        else:
            drive_row_exact(room, at_w + o, at_y + o, k, l, weight, r, at_row, n)
            finish_row_exact(room, at_x + o, at_row, at_out + o + PAD, n, h)


def _catch_up_row(room: Array, at_x: int, at_drive: int, n: int, h: float, steps: int) -> None:
    """Take so many steps towards a drive that stays: x <- x + h (drive - x), until no bit changes any more."""
    x, drive = room[at_x : at_x + n], room[at_drive : at_drive + n]
    for _ in range(steps):
        changes = np.int32(0)
        for j in range(n):
            v = x[j] + h * (drive[j] - x[j])
            changes += np.int32(v != x[j])
            x[j] = v
        if changes == 0:
            return


catch_up_row_fused, catch_up_row_exact = fused(_catch_up_row), helper(_catch_up_row)


@helper
def catch_up_block(room: Array, at_x: int, at_drive: int, n: int, h: float, steps: int) -> None:
    """Take the steps that a block has slept through, with the rounding of every single one."""
    for q in range(BLOCK):
        if room.itemsize == 4:
            catch_up_row_fused(room, at_x + q * STRIDE, at_drive + q * STRIDE, n, h, steps)
        else:
            catch_up_row_exact(room, at_x + q * STRIDE, at_drive + q * STRIDE, n, h, steps)
