"""Innermost loops of the CPU backend: one Euler step of blocks of rows whose data is in the first-level cache.

x, w, y and ``out`` are pointers; row q of each begins q * STRIDE cells after the first. With a stride that the compiler
knows, the rows of a block are one memory range to it, so that few checks for overlap remain and the loops become vector
code. Rows of outputs ``y`` begin PAD cells before their first column, where the virtual cells on the left fit in.

    total = w + sum of the taps in their order,    x <- x + h (total - x),    new y = clip(x, -1, 1)

In float32 a product and a sum may become one rounding (FMA); float64 has the rounding of the reference. All four loops
take the same arguments, because they are called by their address: ``square`` the nine middle entries of A, or any
``taps`` of radius r, a ``row`` of scratch memory, and the number of ``blocks``.
"""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import carray, types

from cnnsim.backends.cpu.compiled import Kernel, call, compiled_at, helper, pointer, pointer_type, tap_type
from cnnsim.backends.cpu.tiles.functions import min_max
from cnnsim.support import Array

BLOCK = 4
"""Rows done together: each row of y is loaded once for all the rows it is a neighbour of. The loops over a block are
written out, loads first, because LLVM makes no vectors of a loop that stores between its loads."""
STRIDE = 1136
"""Cells from row to row: no multiple of 1024, so that the rows of a block do not fight for cache sets."""
PAD = 16
"""One vector of float32: the first real column of y is aligned where x and w are."""


@helper
def _cells(x: Any, w: Any, y: Any, out: Any, square: Any, blocks: int) -> tuple[Array, Array, Array, Array, Array]:
    size = blocks * BLOCK * STRIDE
    return (
        carray(x, (size,)),
        carray(w, (size,)),
        carray(y, (size + 2 * STRIDE,)),
        carray(out, (size,)),
        carray(square, (9,)),
    )


def nine_taps(
    x: Any, w: Any, y: Any, out: Any, n: int, square: Any, taps: Any, tap_count: int, r: int, row: Any, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step by a 3 x 3 matrix."""
    x, w, y, out, a = _cells(x, w, y, out, square, blocks)
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[first : first + BLOCK * STRIDE], w[first : first + BLOCK * STRIDE]
        ys = y[first : first + (BLOCK + 2) * STRIDE]
        outs = out[first : first + BLOCK * STRIDE]
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


def cross(
    x: Any, w: Any, y: Any, out: Any, n: int, square: Any, taps: Any, tap_count: int, r: int, row: Any, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step by a 3 x 3 matrix with nothing in its corners."""
    x, w, y, out, a = _cells(x, w, y, out, square, blocks)
    a1, a3, a4, a5, a7 = a[1], a[3], a[4], a[5], a[7]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[first : first + BLOCK * STRIDE], w[first : first + BLOCK * STRIDE]
        ys = y[first : first + (BLOCK + 2) * STRIDE]
        outs = out[first : first + BLOCK * STRIDE]
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


def isotropic(
    x: Any, w: Any, y: Any, out: Any, n: int, square: Any, taps: Any, tap_count: int, r: int, row: Any, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step by a 3 x 3 matrix with one number in its corners and one on its edges."""
    x, w, y, out, a = _cells(x, w, y, out, square, blocks)
    corner, edge, centre = a[0], a[1], a[4]
    one = x.dtype.type(1)
    for first in range(0, blocks * BLOCK * STRIDE, BLOCK * STRIDE):
        xs, ws = x[first : first + BLOCK * STRIDE], w[first : first + BLOCK * STRIDE]
        ys = y[first : first + (BLOCK + 2) * STRIDE]
        outs = out[first : first + BLOCK * STRIDE]
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


def any_taps(
    x: Any, w: Any, y: Any, out: Any, n: int, square: Any, taps: Any, tap_count: int, r: int, row: Any, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step by any taps of radius r."""
    size = blocks * BLOCK * STRIDE
    x, w, out = carray(x, (size,)), carray(w, (size,)), carray(out, (size,))
    y, taps, total = carray(y, (size + 2 * r * STRIDE,)), carray(taps, (tap_count,)), carray(row, (n,))
    one = x.dtype.type(1)
    for o in range(0, size, STRIDE):
        xs, ws, outs = x[o : o + n], w[o : o + n], out[o + PAD : o + PAD + n]
        for j in range(n):
            total[j] = ws[j]
        for tap in range(taps.size):
            first = o + (r + taps[tap]["k"]) * STRIDE + PAD + taps[tap]["l"]
            ys, c = y[first : first + n], taps[tap]["weight"]
            for j in range(n):
                total[j] += c * ys[j]
        for j in range(n):
            xs[j] += h * (total[j] - xs[j])
        for j in range(n):
            outs[j] = min_max(xs[j], one)


@cache
def loop(kind: Kernel, dtype: np.dtype[Any]) -> Any:
    """Return one of the four loops, compiled for a dtype."""
    integer, cells, taps = types.int64, pointer_type(dtype), pointer_type(tap_type(dtype))
    signature = types.void(
        cells, cells, cells, cells, integer, cells, taps, integer, integer, cells, numba.from_dtype(dtype), integer
    )
    return compiled_at(kind, signature, **({"fastmath": {"contract"}} if dtype == np.float32 else {}))


@helper
def step_blocks(
    address: int, square: Array, taps: Array, r: int, rows: tuple[Array, Array, Array, Array, Array], n: int, h: float,
    blocks: int,
) -> None:  # fmt: skip
    """Step blocks of n columns by the loop at an address; ``rows`` are x, w, y, out and a row of scratch memory."""
    x, w, y, out, row = rows
    call(address, (pointer(x), pointer(w), pointer(y), pointer(out), n, pointer(square), pointer(taps), taps.size, r,
                   pointer(row), h, blocks))  # fmt: skip
