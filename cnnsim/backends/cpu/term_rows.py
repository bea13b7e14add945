"""Rows of a network of terms: differences, products and weighted sums of neighbours, a vector of cells at a time.

Rows are given as a flat array and where they begin; what is worked on lies in ``scratch``, `SCRATCH_ROWS` rows that
stay in the first-level cache: a drive, arguments, values, zeros.
"""

from typing import Any

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.function_rows import copy_row, function_row
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.short_tables import MOST_PLACES, add_table
from cnnsim.support import Array

IDENTITY, LINEAR, STEP = map(int, (FunctionCode.IDENTITY, FunctionCode.LINEAR, FunctionCode.STEP))
SCRATCH_ROWS = 4


@helper
def difference(out: Array, at_out: int, v: Array, at_v: int, less: Array, at_less: int, n: int) -> None:
    """Write v - less."""
    out, v, less = out[at_out : at_out + n], v[at_v : at_v + n], less[at_less : at_less + n]
    for j in range(n):
        out[j] = v[j] - less[j]


@helper
def times_row(out: Array, at_out: int, v: Array, at_v: int, n: int) -> None:
    """Multiply what is there by v."""
    out, v = out[at_out : at_out + n], v[at_v : at_v + n]
    for j in range(n):
        out[j] *= v[j]


@helper
def times_difference(out: Array, at_out: int, v: Array, at_v: int, less: Array, at_less: int, n: int) -> None:
    """Multiply what is there by v - less."""
    out, v, less = out[at_out : at_out + n], v[at_v : at_v + n], less[at_less : at_less + n]
    for j in range(n):
        out[j] *= v[j] - less[j]


@helper
def add_weighted(total: Array, at_total: int, weight: float, f: Array, at_f: int, n: int) -> None:
    """Add weight * f."""
    total, f = total[at_total : at_total + n], f[at_f : at_f + n]
    for j in range(n):
        total[j] += weight * f[j]


@helper
def add_product(total: Array, at_total: int, weights: Array, at_weights: int, f: Array, at_f: int, n: int) -> None:
    """Add weights * f, a weight a cell."""
    total, weights, f = total[at_total : at_total + n], weights[at_weights : at_weights + n], f[at_f : at_f + n]
    for j in range(n):
        total[j] += weights[j] * f[j]


@helper
def add_terms(
    function: int, scratch: Array, at: tuple[int, int, int], padded: Array, shape: Any, r: int, terms: Array,
    taps: Array, planes: Array, numbers: Array,
) -> None:  # fmt: skip
    """Add all terms of a layer to a row of its drive, the first cells of ``scratch``, whose last row is 0.

    ``at`` is (grid, layer, row). ``padded`` and ``planes`` are flat; ``shape`` is what ``padded`` was.
    """
    g, layer, i = at
    _, grids, height, width = shape
    n = width - 2 * r
    v, f, row_of_plane = n, 2 * n, (height - 2 * r) * n
    own = (i + r) * width + r
    for t in range(terms.size):
        term = terms[t]
        if term["layer"] != layer:
            continue
        neighbour, centre, kind, places = term["neighbour"], term["centre"], term["kind"], term["places"]
        times_neighbour, times_centre = term["times_neighbour"], term["times_centre"]
        at_places, values = term["at"], term["values"]
        here = (centre * grids + g) * height * width + own
        factor_here = (times_centre * grids + g) * height * width + own
        squared = times_neighbour == neighbour and times_centre == centre  # f(v) is multiplied by v itself
        short = kind in (LINEAR, STEP) and places <= MOST_PLACES
        one_pass = short and (squared or times_neighbour < 0)
        for tap in range(term["first_tap"], term["end_tap"]):
            away = own + taps[tap]["k"] * width + taps[tap]["l"]
            there = (neighbour * grids + g) * height * width + away
            weight, plane = taps[tap]["weight"], taps[tap]["plane"]
            if one_pass and plane < 0:
                less, at_less = (padded, here) if centre >= 0 else (scratch, 3 * n)
                add_table(kind == STEP, times_neighbour >= 0, scratch, 0, weight, padded, there, less, at_less, n,
                          places, at_places, values, numbers)  # fmt: skip
                continue
            argument, at_argument = padded, there
            if centre >= 0:
                difference(scratch, v, padded, there, padded, here, n)
                argument, at_argument = scratch, v
            result, at_result = argument, at_argument
            if kind != IDENTITY:
                function_row(function, scratch, f, argument, at_argument, n, kind, places, at_places, values, numbers)
                result, at_result = scratch, f
            if times_neighbour >= 0:
                if kind == IDENTITY:
                    copy_row(scratch, f, argument, at_argument, n)
                    result, at_result = scratch, f
                factor = (times_neighbour * grids + g) * height * width + away
                if squared:
                    times_row(scratch, f, argument, at_argument, n)
                elif times_centre >= 0:
                    times_difference(scratch, f, padded, factor, padded, factor_here, n)
                else:
                    times_row(scratch, f, padded, factor, n)
            if plane >= 0:
                add_product(scratch, 0, planes, plane * row_of_plane + i * n, result, at_result, n)
            else:
                add_weighted(scratch, 0, weight, result, at_result, n)
