"""Rows of a stage, a vector of cells at a time: drives, rates, sums, outputs, and what a mask or a limit makes of them.

Rows are given as a flat array and where they begin (see `cnnsim.backends.cpu.tiles.rows`). Nothing is fused: what comes
out has the rounding of the reference, in float32 too.
"""

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE, min_max
from cnnsim.support import Array


@helper
def nine_rates(
    out: Array, at_out: int, w: Array, at_w: int, y: Array, at_y: int, x: Array, at_x: int, taps: Array, n: int
) -> None:
    """Write w + A*y - x by a 3 x 3 matrix without a zero."""
    out, w, x, y = out[at_out : at_out + n], w[at_w : at_w + n], x[at_x : at_x + n], y[at_y : at_y + 3 * STRIDE]
    a0, a1, a2 = taps[0]["weight"], taps[1]["weight"], taps[2]["weight"]
    a3, a4, a5 = taps[3]["weight"], taps[4]["weight"], taps[5]["weight"]
    a6, a7, a8 = taps[6]["weight"], taps[7]["weight"], taps[8]["weight"]
    for j in range(n):
        i = j + PAD
        top = w[j] + a0 * y[i - 1] + a1 * y[i] + a2 * y[i + 1]
        middle = top + a3 * y[i + STRIDE - 1] + a4 * y[i + STRIDE] + a5 * y[i + STRIDE + 1]
        drive = middle + a6 * y[i + 2 * STRIDE - 1] + a7 * y[i + 2 * STRIDE] + a8 * y[i + 2 * STRIDE + 1]
        out[j] = drive - x[j]


@helper
def add_four(
    out: Array, at_out: int, a: Array, at_a: int, b: Array, at_b: int, c: Array, at_c: int, d: Array, at_d: int, n: int,
    weights: tuple[float, float, float, float],
) -> None:  # fmt: skip
    """Add four weighted neighbours to each cell, one after the other as always, in one pass over the row."""
    out, a, b = out[at_out : at_out + n], a[at_a : at_a + n], b[at_b : at_b + n]
    c, d = c[at_c : at_c + n], d[at_d : at_d + n]
    wa, wb, wc, wd = weights
    for j in range(n):
        out[j] = out[j] + wa * a[j] + wb * b[j] + wc * c[j] + wd * d[j]


@helper
def add_weighted(out: Array, at_out: int, weight: float, v: Array, at_v: int, n: int) -> None:
    """Add weight * v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] += weight * v[j]


@helper
def weighted_sum(out: Array, at_out: int, x: Array, at_x: int, weight: float, v: Array, at_v: int, n: int) -> None:
    """Write x + weight * v."""
    out, x, v = out[at_out : at_out + n], x[at_x : at_x + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = x[j] + weight * v[j]


@helper
def weighted_onto(out: Array, at_out: int, x: Array, at_x: int, weight: float, n: int) -> None:
    """Replace what is there by x + weight times it."""
    out, x = out[at_out : at_out + n], x[at_x : at_x + n]
    for j in range(n):
        out[j] = x[j] + weight * out[j]


@helper
def sum_and_output(
    out: Array, at_out: int, y: Array, at_y: int, x: Array, at_x: int, weight: float, v: Array, at_v: int, n: int
) -> None:
    """Write x + weight * v, and its output."""
    out, y, x, v = out[at_out : at_out + n], y[at_y : at_y + n], x[at_x : at_x + n], v[at_v : at_v + n]
    one = out.dtype.type(1)
    for j in range(n):
        s = x[j] + weight * v[j]
        out[j] = s
        y[j] = min_max(s, one)


@helper
def copy_cells(out: Array, at_out: int, v: Array, at_v: int, n: int) -> None:
    """Write v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = v[j]


@helper
def outputs(y: Array, at_y: int, x: Array, at_x: int, n: int) -> None:
    """Write the output of x."""
    y, x = y[at_y : at_y + n], x[at_x : at_x + n]
    one = y.dtype.type(1)
    for j in range(n):
        y[j] = min_max(x[j], one)


@helper
def subtract(out: Array, at_out: int, x: Array, at_x: int, n: int) -> None:
    """Subtract x."""
    out, x = out[at_out : at_out + n], x[at_x : at_x + n]
    for j in range(n):
        out[j] -= x[j]


@helper
def keep_held(out: Array, at_out: int, held: Array, at_held: int, v: Array, at_v: int, n: int) -> None:
    """Write v where cells are held."""
    out, held, v = out[at_out : at_out + n], held[at_held : at_held + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] = v[j] if held[j] > 0 else out[j]


@helper
def set_held(out: Array, at_out: int, held: Array, at_held: int, value: float, n: int) -> None:
    """Write a number where cells are held."""
    out, held = out[at_out : at_out + n], held[at_held : at_held + n]
    for j in range(n):
        out[j] = value if held[j] > 0 else out[j]


@helper
def stop_at_limits(drive: Array, at_drive: int, x: Array, at_x: int, n: int) -> None:
    """Write x for drives that push a state against the limit that it is at."""
    drive, x = drive[at_drive : at_drive + n], x[at_x : at_x + n]
    one = x.dtype.type(1)
    for j in range(n):
        v, d = x[j], drive[j]
        drive[j] = v if ((v >= one) & (d > v)) | ((v <= -one) & (d < v)) else d


@helper
def drives(scratch: Array, at_w: int, at_y: int, taps: Array, r: int, at_out: int, n: int) -> None:
    """Write w + A*y by any taps, where ``at_y`` is the row r above."""
    copy_cells(scratch, at_out, scratch, at_w, n)
    first, tap = at_y + r * STRIDE + PAD, 0
    while tap + 4 <= taps.size:
        a, b, c, d = taps[tap], taps[tap + 1], taps[tap + 2], taps[tap + 3]
        add_four(
            scratch, at_out, scratch, first + a["k"] * STRIDE + a["l"], scratch, first + b["k"] * STRIDE + b["l"],
            scratch, first + c["k"] * STRIDE + c["l"], scratch, first + d["k"] * STRIDE + d["l"], n,
            (a["weight"], b["weight"], c["weight"], d["weight"]),
        )  # fmt: skip
        tap += 4
    while tap < taps.size:
        a = taps[tap]
        add_weighted(scratch, at_out, a["weight"], scratch, first + a["k"] * STRIDE + a["l"], n)
        tap += 1
