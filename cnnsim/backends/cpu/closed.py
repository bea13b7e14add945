"""The compiled closed form of uncoupled cells: `cnnsim.network.cell.uncoupled_state`, cell by cell."""

import math

import numpy as np
from numba import prange

from cnnsim.backends.cpu.boundary import VirtualCells
from cnnsim.backends.cpu.boundary import cell as cell_of
from cnnsim.backends.cpu.compiled import helper, reordered, twins, uncounted
from cnnsim.backends.cpu.drive import Control, control_row
from cnnsim.backends.cpu.planes import all_true, finite_row
from cnnsim.support import Array


@helper
def through_linear(x: float, s: float, a: float, t: float, limited: bool) -> float:
    """Return the state after the time t from |x| <= 1, in the saturation ahead (or at the limit) if it is reached."""
    rate = (a - 1) * x + s
    if rate == 0:
        return x
    ahead = -1.0 if rate < 0 else 1.0
    x, s, rate = x * ahead, s * ahead, rate * ahead
    if a - 1 + s > 0:
        until_one = (1 - x) / rate if a == 1 else math.log1p((a - 1) * (1 - x) / rate) / (a - 1)
        if until_one <= t:
            return ahead * (1.0 if limited else (a + s) + (1 - a - s) * math.exp(-(t - until_one)))
    moved = rate * t if a == 1 else rate * math.expm1((a - 1) * t) / (a - 1)
    return ahead * (x + moved)


@helper
def cell_at(x: float, s: float, a: float, t: float, limited: bool) -> float:
    """Return the state of one cell at time t."""
    if limited or abs(x) <= 1:
        return through_linear(x, s, a, t, limited)
    side = -1.0 if x < 0 else 1.0
    size, push = x * side, s * side
    target = a + push
    if target < 1:
        until_one = math.log((size - target) / (1 - target))
        if until_one < t:
            return side * through_linear(1.0, push, a, t - until_one, limited)
    return side * (target + (size - target) * math.exp(-t))


@helper
def cell_at_rest(x: float, s: float, a: float, one: float, limited: bool) -> float:
    """Return the steady state of one cell, without branches, so that a loop becomes vector code."""
    side = -one if x < 0 else one
    far = (not limited) & (abs(x) > one)
    stays = far & (a + s * side >= one)
    start = side if far else x
    rate = (a - one) * start + s
    ahead = -one if rate < 0 else one
    goes = (a - one) + s * ahead > 0
    there = ahead if limited else a * ahead + s
    there = there if goes else s / (one - a)
    there = start if rate == 0 else there
    there = a * side + s if stays else there
    return there if x - x == 0 else x  # NaN and infinity stay, to be found


@helper
def are_square(taps: Array) -> bool:
    """Return whether these are the nine taps of a 3 x 3 matrix, row by row."""
    square = taps.size == 9
    for tap in range(taps.size):
        square &= taps[tap]["k"] == tap // 3 - 1 and taps[tap]["l"] == tap % 3 - 1
    return square


@reordered
def in_any_order(total: float, value: float, weight: float) -> float:
    """Add value * weight to a sum whose order does not matter."""
    return total + value * weight


@helper
def rest_of_row(
    end: Array, x: Array, z: float, rows: tuple[Array, Array, Array], taps: Array, a: float, limited: bool
) -> bool:
    """Write the steady states of a row of cells, without the first and the last, from three rows of the input.

    The drives are not stored, and the sums keep their order. Return whether all states are finite.
    """
    above, here, below = rows
    one = x.dtype.type(1)
    b0, b1, b2 = taps[0]["weight"], taps[1]["weight"], taps[2]["weight"]
    b3, b4, b5 = taps[3]["weight"], taps[4]["weight"], taps[5]["weight"]
    b6, b7, b8 = taps[6]["weight"], taps[7]["weight"], taps[8]["weight"]
    to, start = end[1:], x[1:]
    for j in range(end.size - 2):
        drive = z + b0 * above[j] + b1 * above[j + 1] + b2 * above[j + 2] + b3 * here[j] + b4 * here[j + 1]
        drive = drive + b5 * here[j + 2] + b6 * below[j] + b7 * below[j + 1] + b8 * below[j + 2]
        to[j] = cell_at_rest(start[j], drive, a, one, limited)
    return finite_row(to[: end.size - 2])


@helper
def rest_of_driven_row(end: Array, x: Array, z: float, rows: tuple[Array, Array, Array], taps: Array, a: float) -> bool:
    """Write what `rest_of_row` does for cells that start at |x| <= 1 with a >= 1, in half the operations.

    Return whether all started there and are finite. A cell whose rate is not 0 comes to the saturation ahead:
    (a - 1) + s has the sign of the rate, rounded or not.
    """
    above, here, below = rows
    one, zero = x.dtype.type(1), x.dtype.type(0)
    b0, b1, b2 = taps[0]["weight"], taps[1]["weight"], taps[2]["weight"]
    b3, b4, b5 = taps[3]["weight"], taps[4]["weight"], taps[5]["weight"]
    b6, b7, b8 = taps[6]["weight"], taps[7]["weight"], taps[8]["weight"]
    to, start, others, lost = end[1:], x[1:], zero, zero
    for j in range(end.size - 2):
        drive = z + b0 * above[j] + b1 * above[j + 1] + b2 * above[j + 2] + b3 * here[j] + b4 * here[j + 1]
        drive = drive + b5 * here[j + 2] + b6 * below[j] + b7 * below[j + 1] + b8 * below[j + 2]
        rate = (a - one) * start[j] + drive
        there = drive - a if rate < zero else a + drive
        there = start[j] if rate == zero else there
        to[j] = there
        lost = in_any_order(lost, there, zero)
        others = in_any_order(others, zero if abs(start[j]) <= one else one, one)
    return others + lost == zero


@helper
def rest_of_inner_row(
    end: Array, x: Array, z: float, rows: tuple[Array, Array, Array], taps: Array, a: float, limited: bool
) -> bool:
    """Write the steady states of a row by the faster of the two loops; return whether all are finite."""
    one = x.dtype.type(1)
    promising = a >= one and not limited and abs(x[x.size // 2]) <= one  # not for planes of saturated states
    if promising and rest_of_driven_row(end, x, z, rows, taps, a):
        return True
    return rest_of_row(end, x, z, rows, taps, a, limited)


@twins
def closed_form(
    x: Array, end: Array, mask: Array, cell: tuple[float, float, bool], control: Control, virtual: VirtualCells,
    first: int, after: int,
) -> bool:  # fmt: skip
    """Write the states of cells that start at x, in the rows from ``first`` on, and return whether all are finite.

    Rows are counted through all grids. ``cell`` is (self-feedback a, time t or infinity, limited). Without a mask
    ``mask`` has no cells.
    """
    _, height, width = x.shape
    one = x.dtype.type(1)
    a, t, limited = cell
    z, bias, u, taps = control
    fine = np.empty(after - first, np.bool_)
    quick = t == math.inf and not bias.size and not mask.size and width > 2 and are_square(taps)
    for line in prange(first, after):
        g, p = line // height, line % height
        row, drive, inputs = uncounted(x)[g, p], uncounted(end)[g, p], uncounted(u)[g]
        if quick and 0 < p < height - 1:
            inside = rest_of_inner_row(
                drive, row, z, (inputs[p - 1], inputs[p], inputs[p + 1]), uncounted(taps), a, limited
            )
            for j in range(0, width, width - 1):
                total = z
                for tap in range(9):
                    total += taps[tap]["weight"] * cell_of(inputs, p + tap // 3 - 1, j + tap % 3 - 1, virtual)
                drive[j] = cell_at_rest(row[j], total, a, one, limited)
                inside &= drive[j] - drive[j] == 0
            fine[line - first] = inside
            continue
        if bias.size:  # which may lie in ``end``
            for j in range(width):
                drive[j] = z + bias[g, p, j]
        else:
            for j in range(width):
                drive[j] = z
        control_row(drive, inputs, p, taps, virtual)
        if t == math.inf:
            for j in range(width):
                drive[j] = cell_at_rest(row[j], drive[j], a, one, limited)
        else:
            for j in range(width):
                drive[j] = cell_at(row[j], drive[j], a, t, limited)
        if mask.size:
            for j in range(width):
                drive[j] = row[j] if mask[g, p, j] else drive[j]
        fine[line - first] = finite_row(drive)
    return all_true(fine)
