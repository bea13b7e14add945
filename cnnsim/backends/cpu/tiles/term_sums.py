"""Sums of the terms of a layer, row by row: differences, functions, products and weighted sums of neighbours.

Rows that one loop writes and reads lie in different arrays: for rows of one array LLVM makes no vector code.
"""

from typing import Any, NamedTuple

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import copy_row, function_row
from cnnsim.backends.cpu.tiles.table_sums import MOST_PLACES, add_table
from cnnsim.support import Array

IDENTITY, LINEAR, STEP = map(int, (FunctionCode.IDENTITY, FunctionCode.LINEAR, FunctionCode.STEP))


class WorkRows(NamedTuple):
    """Rows that stay in the first-level cache, each an array of its own.

    ``drive`` is the sum, ``difference``, ``product`` and ``weights`` are those of one tap; ``zeros`` hold 0, ``mask``
    holds 1 for masked cells, and ``spare`` is free.
    """

    drive: Array
    difference: Array
    product: Array
    weights: Array
    zeros: Array
    mask: Array
    spare: Array


@helper
def load_row(out: Array, plane: Array, i: int, first: int) -> None:
    """Copy cells of row i of a plane from column ``first``, and from the other side of the torus beyond its edges."""
    rows, cols = plane.shape
    row = plane[i if 0 <= i < rows else i % rows]  # a division takes as long as a row of a small grid
    if first >= 0 and first + out.size <= cols:
        copy_row(out, row[first : first + out.size])
        return
    for m in range(out.size):
        out[m] = row[(first + m) % cols]


@helper
def subtract(out: Array, v: Array, less: Array) -> None:
    """Write v - less."""
    for j in range(out.size):
        out[j] = v[j] - less[j]


@helper
def _times(out: Array, v: Array) -> None:
    for j in range(out.size):
        out[j] *= v[j]


@helper
def _times_difference(out: Array, v: Array, less: Array) -> None:
    for j in range(out.size):
        out[j] *= v[j] - less[j]


@helper
def _add_product(total: Array, weights: Array, v: Array) -> None:
    for j in range(total.size):
        total[j] += weights[j] * v[j]


@helper
def add_weighted(total: Array, weight: float, v: Array) -> None:
    """Add weight * v."""
    for j in range(total.size):
        total[j] += weight * v[j]


@helper
def _add_four(total: Array, a: Array, b: Array, c: Array, d: Array, weights: Any) -> None:
    """Add four weighted neighbours to each cell, one after the other as always, in one pass over the row."""
    wa, wb, wc, wd = weights
    for j in range(total.size):
        total[j] = total[j] + wa * a[j] + wb * b[j] + wc * c[j] + wd * d[j]


@helper
def _add_nine(total: Array, rows: Any, taps: Array) -> None:
    """Add nine weighted neighbours to each cell in one pass over the row."""
    a, b, c, d, e, f, g, h, i = rows
    wa, wb, wc, wd, we = (taps[0]["weight"], taps[1]["weight"], taps[2]["weight"], taps[3]["weight"], taps[4]["weight"])
    wf, wg, wh, wi = taps[5]["weight"], taps[6]["weight"], taps[7]["weight"], taps[8]["weight"]
    for j in range(total.size):
        four = total[j] + wa * a[j] + wb * b[j] + wc * c[j] + wd * d[j]
        total[j] = four + we * e[j] + wf * f[j] + wg * g[j] + wh * h[j] + wi * i[j]


@helper
def _neighbours(channel: Array, lines: Array, tap: Any, n: int) -> Array:
    """Return the n cells of a channel at a tap's offset."""
    first = lines[lines.size // 2 + tap["k"]] + tap["l"]
    return channel[first : first + n]


@helper
def _add_linear(total: Array, channel: Array, lines: Array, taps: Array) -> None:
    """Add the weighted neighbours of a channel; all weights are numbers."""
    n, tap = total.size, 0
    if taps.size == 9:
        rows = (
            _neighbours(channel, lines, taps[0], n), _neighbours(channel, lines, taps[1], n),
            _neighbours(channel, lines, taps[2], n), _neighbours(channel, lines, taps[3], n),
            _neighbours(channel, lines, taps[4], n), _neighbours(channel, lines, taps[5], n),
            _neighbours(channel, lines, taps[6], n), _neighbours(channel, lines, taps[7], n),
            _neighbours(channel, lines, taps[8], n),
        )  # fmt: skip
        _add_nine(total, rows, taps)
        return
    while tap + 4 <= taps.size:
        a, b, c, d = taps[tap], taps[tap + 1], taps[tap + 2], taps[tap + 3]
        _add_four(
            total, _neighbours(channel, lines, a, n), _neighbours(channel, lines, b, n),
            _neighbours(channel, lines, c, n), _neighbours(channel, lines, d, n),
            (a["weight"], b["weight"], c["weight"], d["weight"]),
        )  # fmt: skip
        tap += 4
    while tap < taps.size:
        add_weighted(total, taps[tap]["weight"], _neighbours(channel, lines, taps[tap], n))
        tap += 1


@helper
def add_terms(
    function: int, work: WorkRows, channels: Array, lines: Array, layer: int, field: Any, at: tuple[int, int]
) -> None:
    """Add all terms of a layer to a row of its drive.

    ``function`` is the address of `functions`. ``channels`` (channels, cells) hold the rows of a level, those around
    this row begin at ``lines``, the highest first. ``field``: terms, taps, planes of weights and numbers of tables.
    ``at``: row and first column in the grid.
    """
    terms, taps, weights, numbers = field
    drive, v, f, n = work.drive, work.difference, work.product, work.drive.size
    first = lines[lines.size // 2]  # of the cells themselves
    for t in range(terms.size):
        term = terms[t]
        if term["layer"] != layer:
            continue
        neighbour, centre, kind, places = term["neighbour"], term["centre"], term["kind"], term["places"]
        times_neighbour, times_centre = term["times_neighbour"], term["times_centre"]
        if term["linear"]:
            _add_linear(drive, channels[neighbour], lines, taps[term["first_tap"] : term["end_tap"]])
            continue
        places_at, values = numbers[term["at"] : term["at"] + places], numbers[term["values"] :]
        here = channels[centre][first : first + n] if centre >= 0 else work.zeros
        squared = times_neighbour == neighbour and times_centre == centre  # f(v) is multiplied by v itself
        one_pass = kind in (LINEAR, STEP) and places <= MOST_PLACES and (squared or times_neighbour < 0)
        for tap in range(term["first_tap"], term["end_tap"]):
            there = _neighbours(channels[neighbour], lines, taps[tap], n)
            weight, plane = taps[tap]["weight"], taps[tap]["plane"]
            if one_pass and plane < 0:
                add_table(kind == STEP, times_neighbour >= 0, drive, weight, there, here, places_at, values)
                continue
            if centre >= 0:
                subtract(v, there, here)
            else:
                copy_row(v, there)
            function_row(function, f, v, kind, places, places_at, values)
            if squared:
                _times(f, v)
            elif times_neighbour >= 0:
                factor = _neighbours(channels[times_neighbour], lines, taps[tap], n)
                if times_centre >= 0:
                    _times_difference(f, factor, channels[times_centre][first : first + n])
                else:
                    _times(f, factor)
            if plane < 0:
                add_weighted(drive, weight, f)
            else:
                load_row(work.weights, weights[plane], at[0], at[1])
                _add_product(drive, work.weights, f)
