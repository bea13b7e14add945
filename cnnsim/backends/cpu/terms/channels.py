"""Channels of a tile: a row of each, brought from the state, from past states or inputs, and its virtual cells."""

from typing import Any

from cnnsim.backends.codes import NOTHING, BoundaryCode
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.terms.function_rows import copy_row, function_row
from cnnsim.backends.cpu.terms.groups import Surround
from cnnsim.backends.cpu.terms.layout import TermLayout
from cnnsim.backends.cpu.terms.rows import load_cells
from cnnsim.support import Array

FIXED, PERIODIC = int(BoundaryCode.FIXED), int(BoundaryCode.PERIODIC)


@helper
def find_lines(lines: Array, i: int, slot: int, rows: int, low: int, code: int, at: TermLayout) -> None:
    """Find where in a channel the rows around row i of the grid begin, from the highest on; i itself is in ``slot``."""
    r = lines.size // 2
    for k in range(-r, r + 1):
        real = i + k
        if not 0 <= real < rows and (low or code != PERIODIC):
            if code == FIXED:
                lines[k + r] = at.ring * at.stride
                continue
            real = real % rows if code == PERIODIC else min(max(real, 0), rows - 1)
        there = slot + real - i  # no division: it would take as long as a row of a small grid
        there += at.ring if there < 0 else -at.ring if there >= at.ring else 0
        lines[k + r] = there * at.stride


@helper
def virtual_cell(scratch: Array, at: int, n: int, j: int, code: int, constant: float) -> Any:
    """Return what stands for cell j of a row of n cells, beyond its ends."""
    if code == FIXED:
        return constant
    return scratch[at + (j % n if code == PERIODIC else min(max(j, 0), n - 1))]


@helper
def fill_channels(
    function: int, scratch: Array, same: Array, at: int, to: int, apart: tuple[int, int, int],
    planes: tuple[Array, Array, Array], when: tuple[int, int, int], channels: Array, characteristic: Any,
    grid: tuple[int, int, int, int], part: tuple[int, int, int], sides: tuple[bool, bool], edge: Surround,
) -> None:  # fmt: skip
    """Write a row of all channels, from ``to`` on. For ``same`` see `add_terms`.

    The row of the state of a stage begins at ``at``; NOTHING: it is that of the step, in the planes.

    ``apart``: a row to work in, the distance between channels and between layers of the state. ``planes`` are the first
    state, later ones and inputs; ``when`` the number of the step, how far ahead it looks, how many states are kept.
    ``grid``: its number, layers, rows, columns. ``part``: the row, its first column and its columns; ``sides``: whether
    they reach the grid's first and last one.
    """
    start, states, inputs = planes
    spare, of_channel, of_layer = apart
    number, ahead, kept = when
    g, layers, rows, cols = grid
    i, first, n = part
    r, code, of_input, of_state = edge
    kind, places, at_places, values, numbers = characteristic
    inside = 0 <= i < rows and first >= 0 and first + n <= cols
    for m in range(channels.size):
        channel, out = channels[m], to + m * of_channel
        plane, layer, step = channel["plane"], channel["layer"], number + ahead - channel["ago"]
        begin, source, at_source = (g * layers + layer) * rows * cols, same, at + layer * of_layer
        if plane >= 0:
            load_cells(inputs, plane * start.size + begin, rows, cols, i, first, n, scratch, out)
        else:
            if channel["ago"] > 0 or at == NOTHING:
                source, at_source = start, begin  # before t = 0 the state was x(0)
                if step > 0:
                    source, at_source = states, begin + step % kept * start.size
                if inside:
                    at_source += i * cols + first
                else:
                    load_cells(source, at_source, rows, cols, i, first, n, scratch, spare)
                    source, at_source = same, spare
            if channel["output"]:
                function_row(function, scratch, out, source, at_source, n, kind, places, at_places, values, numbers)
            else:
                copy_row(scratch, out, source, at_source, n)
        constant = of_input if plane >= 0 else of_state
        for q in range(r):
            if sides[0]:
                scratch[out - 1 - q] = virtual_cell(scratch, out, n, -1 - q, code, constant)
            if sides[1]:
                scratch[out + n + q] = virtual_cell(scratch, out, n, n + q, code, constant)
