"""Scratch memory of a thread that steps tiles of a linear template: rows in, outputs, and virtual cells.

Rows lie `STRIDE` cells apart in one flat array without a reference count (`compiled.uncounted`).
"""

from typing import Any

from cnnsim.backends.codes import BoundaryCode
from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import clip_row, copy_row, fill
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.backends.cpu.tiles.term_sums import load_row
from cnnsim.support import Array

ZERO_FLUX, PERIODIC = int(BoundaryCode.ZERO_FLUX), int(BoundaryCode.PERIODIC)


@helper
def cache_line(scratch: Array) -> int:
    """Return the first cell of an array that begins a cache line."""
    return ((64 - (scratch.ctypes.data & 63)) & 63) // scratch.itemsize


@helper
def move(scratch: Array, source: int, target: int, n: int) -> None:
    """Copy n cells within the scratch memory."""
    copy_row(scratch[target : target + n], scratch[source : source + n])


@helper
def clear(scratch: Array, width: int) -> None:
    """Write 0 to all cells that rows of tiles of this width and their halo use.

    Unused cells of a vector are computed as well. Uninitialised memory often holds subnormal numbers, with which
    arithmetic takes three times as long.
    """
    for row in range(0, scratch.size, STRIDE):
        fill(scratch[row : row + min(width + 4 * PAD, STRIDE, scratch.size - row)], 0)


@helper
def load_padded(scratch: Array, at: int, plane: Array, i: int, first: int, n: int, whole: int) -> None:
    """Load n cells of a row (see `load_row`) and set the cells from n to ``whole`` to 0.

    Without this they would decay to subnormal numbers.
    """
    fill(scratch[at + n : at + whole], 0)
    load_row(scratch[at : at + n], plane, i, first)


@helper
def clip_rows(scratch: Array, x: int, y: int, n: int, rows: int) -> None:
    """Write the outputs of some rows."""
    for o in range(0, rows * STRIDE, STRIDE):
        out = scratch[y + o + PAD : y + o + PAD + n]
        clip_row(out, scratch[x + o : x + o + n], out.dtype.type(1))


@helper
def set_sides(scratch: Array, row: int, n: int, sides: tuple[bool, bool], edge: tuple[int, int, Any]) -> None:
    """Set the virtual cells to the left and right of a row of y, where it reaches the grid's first or last column."""
    (left, right), (r, code, c), first = sides, edge, row + PAD
    if left:
        fill(scratch[first - r : first], scratch[first] if code == ZERO_FLUX else c)
    if right:
        fill(scratch[first + n : first + n + r], scratch[first + n - 1] if code == ZERO_FLUX else c)


@helper
def set_virtual_row(scratch: Array, row: int, nearest: int, n: int, edge: tuple[int, int, Any]) -> None:
    """Set a row of y above or below the grid, whose nearest row in the grid is another one."""
    _, code, c = edge
    if code == ZERO_FLUX:
        move(scratch, nearest, row, n + 2 * PAD)
    else:
        fill(scratch[row : row + n + 2 * PAD], c)
