"""Rows of the channels that terms look at: states, outputs, past states and inputs, with their virtual cells."""

from typing import Any

from cnnsim.backends.codes import NOTHING, BoundaryCode
from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import copy_row, function_row
from cnnsim.backends.cpu.tiles.term_sums import load_row
from cnnsim.support import Array

FIXED, PERIODIC = int(BoundaryCode.FIXED), int(BoundaryCode.PERIODIC)


@helper
def find_lines(lines: Array, i: int, slot: int, ring: tuple[int, int, int], grid: tuple[int, int, bool]) -> None:
    """Find where in a channel the rows around row i begin, the highest first; i itself is in ``slot``.

    ``ring``: the rows that are kept, after which one has the cells beyond a fixed boundary; the cells from row to row,
    and from the start of a row to its first cell. ``grid``: rows, boundary code, whether all rows are in the ring.
    """
    r, (size, stride, first), (rows, code, whole) = lines.size // 2, ring, grid
    for k in range(-r, r + 1):
        real = i + k
        if not 0 <= real < rows and (whole or code != PERIODIC):
            if code == FIXED:
                lines[k + r] = size * stride + first
                continue
            real = real % rows if code == PERIODIC else min(max(real, 0), rows - 1)
        there = slot + real - i  # no division: it would take as long as a row of a small grid
        there += size if there < 0 else -size if there >= size else 0
        lines[k + r] = there * stride + first


@helper
def _virtual_cell(row: Array, j: int, code: int, constant: float) -> Any:
    """Return the virtual cell j of a row, beyond its ends."""
    if code == FIXED:
        return constant
    return row[j % row.size if code == PERIODIC else min(max(j, 0), row.size - 1)]


@helper
def fill_channels(
    rule: Any, planes: Any, rings: Array, to: int, stages: Array, place: int, when: tuple[int, int],
    part: tuple[int, int, int, int],
) -> None:  # fmt: skip
    """Write a row of all channels into the rings of a level, from cell ``to``.

    Arguments: ``rule``: the address of `functions`, the channels, the output characteristic (kind, places, values) and
    the boundary (radius, code, constants of input and state). ``planes``: the first state, later states, inputs, the
    number of the grid and a spare row. The stage is at ``place`` of the live rows ``stages``, NOTHING: it is the state.
    ``when``: the number of the step, and by how many steps the stage looks ahead. ``part``: row, first and last
    column, and whether the columns end at the grid's edges.
    """
    function, channels, (kind, at, values), (r, code, of_input, of_state) = rule
    start, states, inputs, g, spare = planes
    i, first, n, own_edges = part
    kept, (_, _, rows, cols) = states.shape[0], start.shape
    inside = 0 <= i < rows and first >= 0 and first + n <= cols
    for m in range(channels.size):
        channel, out = channels[m], rings[m][to : to + n]
        plane, layer, step = channel["plane"], channel["layer"], when[0] + when[1] - channel["ago"]
        if plane >= 0:
            load_row(out, inputs[plane, g, layer], i, first)
        else:
            source = spare[:n]
            if channel["ago"] == 0 and place != NOTHING:
                source = stages[layer, place][:n]
            else:
                state = states[step % kept, g, layer] if step > 0 else start[g, layer]  # before t = 0 it was x(0)
                if inside:
                    source = state[i][first : first + n]
                else:
                    load_row(source, state, i, first)
            if channel["output"]:
                function_row(function, out, source, kind, at.size, at, values)
            else:
                copy_row(out, source)
        if own_edges:
            constant = of_input if plane >= 0 else of_state
            for q in range(r):
                if first == 0:
                    rings[m][to - 1 - q] = _virtual_cell(out, -1 - q, code, constant)
                if first + n == cols:
                    rings[m][to + n + q] = _virtual_cell(out, n + q, code, constant)
