"""One Euler step of a block of rows, its data in the first-level cache: the innermost loops of the CPU backend.

Everything lies in one flat array, ``scratch``; x, w, y and ``out`` say where a block begins, and row q of it begins at
q * STRIDE. With a stride known to the compiler, all rows of a block are one memory range to it, so that few checks for
overlap are left and the loops become vector code. One array, because every slice that is handed to another function
costs two atomic instructions for its reference count; it is handed over once for each of its uses, because parts of
one array are not checked for overlap but taken to overlap. Rows of outputs ``y`` begin PAD cells before their first
column, where the virtual cells on the left fit in.

    total = w + sum of the taps in their order,    x <- x + h (total - x),    new y = clip(x, -1, 1)
"""

from cnnsim.backends.cpu.jit.compile import fused, helper
from cnnsim.support import Array

BLOCK = 4
"""Rows done together: each row of y is loaded once for all the rows it is a neighbour of. The loops over a block are
written out, loads first, because LLVM makes no vectors of a loop that stores between its loads."""
STRIDE = 1136
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
    h: float, blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by a 3 x 3 matrix whose nine entries begin at ``at_a``."""
    a = a[at_a : at_a + 9]
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[at_x + first : at_x + first + BLOCK * STRIDE], w[at_w + first : at_w + first + BLOCK * STRIDE]
        ys = y[at_y + first : at_y + first + (BLOCK + 2) * STRIDE]
        outs = out[at_out + first : at_out + first + BLOCK * STRIDE]
        for j in range(n):
            i = j + PAD
            l0, m0, r0 = ys[i - 1], ys[i], ys[i + 1]
            l1, m1, r1 = ys[i + STRIDE - 1], ys[i + STRIDE], ys[i + STRIDE + 1]
            l2, m2, r2 = ys[i + 2 * STRIDE - 1], ys[i + 2 * STRIDE], ys[i + 2 * STRIDE + 1]
            l3, m3, r3 = ys[i + 3 * STRIDE - 1], ys[i + 3 * STRIDE], ys[i + 3 * STRIDE + 1]
            l4, m4, r4 = ys[i + 4 * STRIDE - 1], ys[i + 4 * STRIDE], ys[i + 4 * STRIDE + 1]
            l5, m5, r5 = ys[i + 5 * STRIDE - 1], ys[i + 5 * STRIDE], ys[i + 5 * STRIDE + 1]
            t0 = ws[j] + a0 * l0 + a1 * m0 + a2 * r0 + a3 * l1 + a4 * m1 + a5 * r1 + a6 * l2 + a7 * m2 + a8 * r2
            t1 = (
                ws[j + STRIDE] + a0 * l1 + a1 * m1 + a2 * r1 + a3 * l2 + a4 * m2 + a5 * r2 + a6 * l3 + a7 * m3 + a8 * r3
            )
            t2 = (
                ws[j + 2 * STRIDE]
                + a0 * l2
                + a1 * m2
                + a2 * r2
                + a3 * l3
                + a4 * m3
                + a5 * r3
                + a6 * l4
                + a7 * m4
                + a8 * r4
            )
            t3 = (
                ws[j + 3 * STRIDE]
                + a0 * l3
                + a1 * m3
                + a2 * r3
                + a3 * l4
                + a4 * m4
                + a5 * r4
                + a6 * l5
                + a7 * m5
                + a8 * r5
            )
            x0, x1, x2, x3 = xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE]
            x0 += h * (t0 - x0)
            x1 += h * (t1 - x1)
            x2 += h * (t2 - x2)
            x3 += h * (t3 - x3)
            xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE] = x0, x1, x2, x3
            outs[i] = min_max(x0, one)
            outs[i + STRIDE] = min_max(x1, one)
            outs[i + 2 * STRIDE] = min_max(x2, one)
            outs[i + 3 * STRIDE] = min_max(x3, one)


@fused
def cross(
    x: Array, at_x: int, w: Array, at_w: int, y: Array, at_y: int, out: Array, at_out: int, n: int, a: Array, at_a: int,
    h: float, blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by a 3 x 3 matrix with nothing in its corners."""
    a = a[at_a : at_a + 9]
    a1, a3, a4, a5, a7 = a[1], a[3], a[4], a[5], a[7]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[at_x + first : at_x + first + BLOCK * STRIDE], w[at_w + first : at_w + first + BLOCK * STRIDE]
        ys = y[at_y + first : at_y + first + (BLOCK + 2) * STRIDE]
        outs = out[at_out + first : at_out + first + BLOCK * STRIDE]
        for j in range(n):
            i = j + PAD
            m0 = ys[i]
            l1, m1, r1 = ys[i + STRIDE - 1], ys[i + STRIDE], ys[i + STRIDE + 1]
            l2, m2, r2 = ys[i + 2 * STRIDE - 1], ys[i + 2 * STRIDE], ys[i + 2 * STRIDE + 1]
            l3, m3, r3 = ys[i + 3 * STRIDE - 1], ys[i + 3 * STRIDE], ys[i + 3 * STRIDE + 1]
            l4, m4, r4 = ys[i + 4 * STRIDE - 1], ys[i + 4 * STRIDE], ys[i + 4 * STRIDE + 1]
            m5 = ys[i + 5 * STRIDE]
            t0 = ws[j] + a1 * m0 + a3 * l1 + a4 * m1 + a5 * r1 + a7 * m2
            t1 = ws[j + STRIDE] + a1 * m1 + a3 * l2 + a4 * m2 + a5 * r2 + a7 * m3
            t2 = ws[j + 2 * STRIDE] + a1 * m2 + a3 * l3 + a4 * m3 + a5 * r3 + a7 * m4
            t3 = ws[j + 3 * STRIDE] + a1 * m3 + a3 * l4 + a4 * m4 + a5 * r4 + a7 * m5
            x0, x1, x2, x3 = xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE]
            x0 += h * (t0 - x0)
            x1 += h * (t1 - x1)
            x2 += h * (t2 - x2)
            x3 += h * (t3 - x3)
            xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE] = x0, x1, x2, x3
            outs[i] = min_max(x0, one)
            outs[i + STRIDE] = min_max(x1, one)
            outs[i + 2 * STRIDE] = min_max(x2, one)
            outs[i + 3 * STRIDE] = min_max(x3, one)


@fused
def isotropic(
    x: Array, at_x: int, w: Array, at_w: int, y: Array, at_y: int, out: Array, at_out: int, n: int, a: Array, at_a: int,
    h: float, blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by a 3 x 3 matrix with one number in its corners and one on its edges."""
    a = a[at_a : at_a + 9]
    corner, edge, centre = a[0], a[1], a[4]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[at_x + first : at_x + first + BLOCK * STRIDE], w[at_w + first : at_w + first + BLOCK * STRIDE]
        ys = y[at_y + first : at_y + first + (BLOCK + 2) * STRIDE]
        outs = out[at_out + first : at_out + first + BLOCK * STRIDE]
        for j in range(n):
            i = j + PAD
            y0, y1, y2 = ys[i], ys[i + STRIDE], ys[i + 2 * STRIDE]
            y3, y4, y5 = ys[i + 3 * STRIDE], ys[i + 4 * STRIDE], ys[i + 5 * STRIDE]
            s0 = ys[i - 1] + ys[i + 1]
            s1 = ys[i + STRIDE - 1] + ys[i + STRIDE + 1]
            s2 = ys[i + 2 * STRIDE - 1] + ys[i + 2 * STRIDE + 1]
            s3 = ys[i + 3 * STRIDE - 1] + ys[i + 3 * STRIDE + 1]
            s4 = ys[i + 4 * STRIDE - 1] + ys[i + 4 * STRIDE + 1]
            s5 = ys[i + 5 * STRIDE - 1] + ys[i + 5 * STRIDE + 1]
            t0 = ((ws[j] + centre * y1) + edge * (s1 + (y0 + y2))) + corner * (s0 + s2)
            t1 = ((ws[j + STRIDE] + centre * y2) + edge * (s2 + (y1 + y3))) + corner * (s1 + s3)
            t2 = ((ws[j + 2 * STRIDE] + centre * y3) + edge * (s3 + (y2 + y4))) + corner * (s2 + s4)
            t3 = ((ws[j + 3 * STRIDE] + centre * y4) + edge * (s4 + (y3 + y5))) + corner * (s3 + s5)
            x0, x1, x2, x3 = xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE]
            x0 += h * (t0 - x0)
            x1 += h * (t1 - x1)
            x2 += h * (t2 - x2)
            x3 += h * (t3 - x3)
            xs[j], xs[j + STRIDE], xs[j + 2 * STRIDE], xs[j + 3 * STRIDE] = x0, x1, x2, x3
            outs[i] = min_max(x0, one)
            outs[i + STRIDE] = min_max(x1, one)
            outs[i + 2 * STRIDE] = min_max(x2, one)
            outs[i + 3 * STRIDE] = min_max(x3, one)


def _drive_row(scratch: Array, at_w: int, at_y: int, taps: Array, r: int, at_total: int, n: int) -> None:
    """Write w + A*y of one row, where ``at_y`` is the row r above it."""
    total, row = scratch[at_total : at_total + n], scratch[at_w : at_w + n]
    for j in range(n):
        total[j] = row[j]
    for tap in range(taps.size):
        first = at_y + (r + taps[tap]["k"]) * STRIDE + PAD + taps[tap]["l"]
        line = scratch[first : first + n]
        c = taps[tap]["weight"]
        for j in range(n):
            total[j] += c * line[j]


def _finish_row(scratch: Array, at_x: int, at_total: int, at_out: int, n: int, h: float) -> None:
    """Go from A*y + w to the new state and its output."""
    x, total, out = scratch[at_x : at_x + n], scratch[at_total : at_total + n], scratch[at_out : at_out + n]
    one = scratch.dtype.type(1)
    for j in range(n):
        x[j] += h * (total[j] - x[j])
    for j in range(n):
        out[j] = min_max(x[j], one)


drive_row_fused, finish_row_fused = fused(_drive_row), fused(_finish_row)
drive_row_exact, finish_row_exact = helper(_drive_row), helper(_finish_row)


@helper
def any_taps(
    scratch: Array, at_x: int, at_w: int, at_y: int, at_out: int, n: int, taps: Array, r: int, at_row: int, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by any taps of radius r; in float64 rounded like the reference, in float32 with FMA."""
    for q in range(blocks * BLOCK):
        o = q * STRIDE
        if scratch.itemsize == 4:
            drive_row_fused(scratch, at_w + o, at_y + o, taps, r, at_row, n)
            finish_row_fused(scratch, at_x + o, at_row, at_out + o + PAD, n, h)
        else:
            drive_row_exact(scratch, at_w + o, at_y + o, taps, r, at_row, n)
            finish_row_exact(scratch, at_x + o, at_row, at_out + o + PAD, n, h)
