"""Compiled loops of the CPU backend. Planes are (n, rows, cols) and contiguous; sums run in the reference's order.

A plane that is not given has no cells. Names follow the equations, see `cnnsim.network.cell`.
"""

from typing import Any

import numpy as np
from numba import prange

from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.support import Array


@helper
def fill_virtual(around: Array, rows: Array, cols: Array, r: int, constant: float) -> None:
    """Set the virtual cells of one padded grid from its real cells, or to the constant."""
    height, width = around.shape
    for p in range(height):
        real = width - 2 * r if r <= p < height - r else 0
        for q in range(width - real):
            at = q if q < r else q + real
            if rows[p] < 0 or cols[at] < 0:
                around[p, at] = constant
            else:
                around[p, at] = around[rows[p] + r, cols[at] + r]


@helper
def add_taps(total: Array, around: Array, k: Array, l: Array, weight: Array, i: int, r: int) -> None:
    """Add the taps' weighted neighbours of row i of one grid to ``total``."""
    cols = total.size
    for tap in range(weight.size):
        first = r + l[tap]
        line = around[i + r + k[tap], first : first + cols]
        c = weight[tap]
        for j in range(cols):
            total[j] += c * line[j]


# Plain loops for what NumPy does in a word: each of its words takes numba up to two seconds to compile.


@helper
def copy_row(row: Array, out: Array) -> None:
    """Copy a row."""
    for j in range(row.size):
        out[j] = row[j]


@helper
def most(values: Array) -> float:
    """Return the largest value; NaN if there is one."""
    largest = values[0]
    for value in values:
        if not value <= largest:
            largest = value
    return largest


@helper
def every(values: Array) -> bool:
    """Return whether all are true."""
    count = 0
    for value in values:
        count += value
    return count == values.size


@helper
def clip_row(row: Array, out: Array) -> None:
    """Write clip(row, -1, 1); NaN stays NaN."""
    one = row.dtype.type(1)
    for j in range(row.size):
        v = row[j]
        v = one if v > one else v
        out[j] = -one if v < -one else v


@twins
def stepped(
    x: Array, w: Array, held: Array, k: Array, l: Array, weight: Array, rows: Array, cols: Array, r: int,
    constant: float, ha: Array, hb: Array, steps: int, check_every: int, rest: float, step_freezes: bool, walls: bool,
) -> tuple[int, bool, float]:  # fmt: skip
    """Run Runge-Kutta steps on x in place; ``ha`` and ``hb`` are the scheme's table times its gain.

    Returns the steps taken, whether the network settled, and the largest |dx/dt| (NaN if it was not looked at:
    ``check_every`` 0).
    """
    n, height, width = x.shape
    around = np.empty((n, height + 2 * r, width + 2 * r), x.dtype)
    stage = np.empty_like(x)
    slopes = np.empty((hb.size, n, height, width), x.dtype)
    steepest = np.empty(n * height, x.dtype)
    stuck = np.empty(n * height, np.bool_)
    done = 0
    settled: Any = False
    largest: Any = np.nan
    while True:
        looking = check_every > 0 and (done % check_every == 0 or done == steps)
        if done == steps and not looking:
            break
        for i in range(hb.size):
            for line in prange(n * height):
                g, p = line // height, line % height
                row = stage[g, p]
                copy_row(x[g, p], row)
                for earlier in range(i):
                    c = ha[i, earlier]
                    for j in range(width):
                        row[j] += c * slopes[earlier, g, p, j]
                if walls:
                    clip_row(row, row)
                clip_row(row, around[g, p + r, r : r + width])
            for g in prange(n):
                fill_virtual(around[g], rows, cols, r, constant)
            for line in prange(n * height):
                g, p = line // height, line % height
                row = slopes[i, g, p]
                copy_row(w[g, p], row)
                add_taps(row, around[g], k, l, weight, p, r)
                if looking and i == 0:
                    steepest[line], stuck[line] = look(row, x[g, p], held[g, p] if held.size else held[0, 0], walls)
                for j in range(width):
                    row[j] -= stage[g, p, j]
            if looking and i == 0:
                largest = most(steepest)
                settled = largest <= rest or (step_freezes and every(stuck))
                if settled or done == steps:
                    return done, settled, largest
        for line in prange(n * height):
            g, p = line // height, line % height
            row = x[g, p]
            if held.size:
                for j in range(width):
                    if not held[g, p, j]:
                        v = row[j]
                        for i in range(hb.size):
                            v += hb[i] * slopes[i, g, p, j]
                        row[j] = v
            else:
                for i in range(hb.size):
                    c = hb[i]
                    for j in range(width):
                        row[j] += c * slopes[i, g, p, j]
            if walls:
                clip_row(row, row)
        done += 1
    return done, settled, largest


@helper
def look(drive: Array, x: Array, held: Array, walls: bool) -> tuple[float, bool]:
    """Return the largest |dx/dt| of a row, and whether each of its free cells is saturated for good."""
    zero, one = x.dtype.type(0), x.dtype.type(1)
    steepest = zero
    stuck = True
    for j in range(x.size):
        if held.size and held[j]:
            continue
        slope = drive[j] - x[j]
        if walls and ((x[j] >= one and slope > zero) or (x[j] <= -one and slope < zero)):
            slope = zero
        steepest = max(steepest, abs(slope))
        if not ((x[j] >= one and drive[j] >= one) or (x[j] <= -one and drive[j] <= -one)):
            stuck = False
    return steepest, stuck


@twins
def all_finite(x: Array) -> bool:
    """Return whether no value is NaN or infinite: x * 0 is 0 exactly for finite x."""
    n = x.shape[0] * x.shape[1]
    fine = np.empty(n, np.bool_)
    zero = x.dtype.type(0)
    for line in prange(n):
        row = x[line // x.shape[1], line % x.shape[1]]
        total = zero
        for j in range(row.size):
            total += row[j] * zero
        fine[line] = total == zero
    return every(fine)


@twins
def clip(x: Array, out: Array) -> None:
    """Write the output characteristic of x."""
    for line in prange(x.shape[0] * x.shape[1]):
        clip_row(x[line // x.shape[1], line % x.shape[1]], out[line // x.shape[1], line % x.shape[1]])
