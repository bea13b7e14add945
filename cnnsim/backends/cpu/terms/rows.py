"""Rows of a network of terms: differences, products and weighted sums of neighbours, a vector of cells at a time.

Rows are given as a flat array and where they begin; what is worked on lies in ``scratch``: channels, and `WORK_ROWS`
rows that stay in the first-level cache, a drive, arguments, values, weights, zeros.
"""

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.terms.function_rows import copy_row, function_row
from cnnsim.backends.cpu.terms.groups import TermArrays
from cnnsim.backends.cpu.terms.short_tables import MOST_PLACES, add_table
from cnnsim.backends.cpu.tiles.row_sums import add_weighted
from cnnsim.support import Array

IDENTITY, LINEAR, STEP = map(int, (FunctionCode.IDENTITY, FunctionCode.LINEAR, FunctionCode.STEP))
WORK_ROWS = 5


@helper
def load_cells(
    plane: Array, at: int, rows: int, cols: int, i: int, first: int, n: int, scratch: Array, at_row: int
) -> None:
    """Copy n cells of row i from column ``first`` on, on the other side of the torus where that leaves the grid.

    The grid begins at ``at`` of a flat ``plane``.
    """
    row = at + (i if 0 <= i < rows else i % rows) * cols  # a division takes as long as a row of a small grid
    if first >= 0 and first + n <= cols:
        copy_row(scratch, at_row, plane, row + first, n)
        return
    for m in range(n):
        scratch[at_row + m] = plane[row + (first + m) % cols]


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
def add_product(total: Array, at_total: int, weights: Array, at_weights: int, f: Array, at_f: int, n: int) -> None:
    """Add weights * f, a weight a cell."""
    total, weights, f = total[at_total : at_total + n], weights[at_weights : at_weights + n], f[at_f : at_f + n]
    for j in range(n):
        total[j] += weights[j] * f[j]


@helper
def add_terms(
    function: int, scratch: Array, same: Array, work: tuple[int, int], channels: tuple[int, int], lines: Array,
    layer: int, field: TermArrays, part: tuple[int, int, int, int, int],
) -> None:  # fmt: skip
    """Add all terms of a layer to a row of its drive, the first of the rows of ``work``, of which the last is 0.

    ``same`` is the scratch once more: two parts of one array are not checked for overlap but taken to overlap.

    ``work`` and ``channels`` are where the first row, or channel, begins and how far it is to the next; ``lines`` where
    in a channel the rows around begin, from the highest on. ``part`` says which cells they are: (row, first column,
    columns), and the grid's (rows, columns).
    """
    _, terms, taps, weights, numbers = field
    at, stride = work
    at_channels, size = channels
    i, first, n, rows, cols = part
    v, f, at_weights, zeros = at + stride, at + 2 * stride, at + 3 * stride, at + 4 * stride
    r = lines.size // 2
    inside = first >= 0 and first + n <= cols
    for t in range(terms.size):
        term = terms[t]
        if term["layer"] != layer:
            continue
        neighbour, centre, kind, places = term["neighbour"], term["centre"], term["kind"], term["places"]
        times_neighbour, times_centre = term["times_neighbour"], term["times_centre"]
        at_places, values = term["at"], term["values"]
        here = at_channels + centre * size + lines[r]
        factor_here = at_channels + times_centre * size + lines[r]
        squared = times_neighbour == neighbour and times_centre == centre  # f(v) is multiplied by v itself
        short = kind in (LINEAR, STEP) and places <= MOST_PLACES
        one_pass = short and (squared or times_neighbour < 0)
        for tap in range(term["first_tap"], term["end_tap"]):
            away = at_channels + lines[r + taps[tap]["k"]] + taps[tap]["l"]
            there = away + neighbour * size
            weight, plane = taps[tap]["weight"], taps[tap]["plane"]
            if one_pass and plane < 0:
                less = here if centre >= 0 else zeros
                add_table(kind == STEP, times_neighbour >= 0, scratch, at, weight, same, there, same, less, n,
                          places, at_places, values, numbers)  # fmt: skip
                continue
            argument = there
            if centre >= 0:
                difference(scratch, v, same, there, same, here, n)
                argument = v
            result = argument
            if kind != IDENTITY:
                function_row(function, scratch, f, same, argument, n, kind, places, at_places, values, numbers)
                result = f
            if times_neighbour >= 0:
                if kind == IDENTITY:
                    copy_row(scratch, f, same, argument, n)
                    result = f
                factor = away + times_neighbour * size
                if squared:
                    times_row(scratch, f, same, argument, n)
                elif times_centre >= 0:
                    times_difference(scratch, f, same, factor, same, factor_here, n)
                else:
                    times_row(scratch, f, same, factor, n)
            if plane < 0:
                add_weighted(scratch, at, weight, same, result, n)
            elif inside:
                add_product(scratch, at, weights, (plane * rows + i % rows) * cols + first, scratch, result, n)
            else:
                load_cells(weights, plane * rows * cols, rows, cols, i, first, n, scratch, at_weights)
                add_product(scratch, at, same, at_weights, same, result, n)
