"""The scratch memory in which a thread steps tiles: its layout, and how rows get into it."""

from typing import NamedTuple

from cnnsim.backends.cpu.euler.rows import BLOCK, PAD, STRIDE
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array

GROUP = 4 * BLOCK
"""Rows that a level of a tile steps at a time: what is kept of the last ones is copied once for all of them."""
SLACK = 16
"""Rows that stream past before the live ones are moved back to the start of their buffer."""


class TileLayout(NamedTuple):
    """Where things begin: live rows of x and w, two groups of y, the rows of y kept for each level, a drive,
    a row, and the nine entries of a 3 x 3 matrix.
    """

    x: int
    w: int
    y: int
    new: int
    kept: int
    drive: int
    row: int
    square: int


@helper
def tile_cells(depth: int, r: int) -> int:
    """Return the size of a thread's scratch for tiles of this depth."""
    return STRIDE * (2 * (depth * r + GROUP + SLACK) + 2 * (GROUP + 2 * r) + 2 * r * depth + GROUP + 2)


@helper
def tile_layout(scratch: Array, depth: int, r: int) -> TileLayout:
    """Lay the buffers out, the first at the start of a cache line."""
    x = ((64 - (scratch.ctypes.data & 63)) & 63) // scratch.itemsize
    live, block = STRIDE * (depth * r + GROUP + SLACK), STRIDE * (GROUP + 2 * r)
    y = x + 2 * live
    kept = y + 2 * block
    drive = kept + STRIDE * 2 * r * depth
    row = drive + STRIDE * GROUP
    return TileLayout(x, x + live, y, y + block, kept, drive, row, row + STRIDE)


@helper
def move(source: Array, i: int, target: Array, j: int, n: int) -> None:
    """Copy n cells; a loop, because an assignment of slices costs numba a check for overlap ten times as dear."""
    a, b = source[i : i + n], target[j : j + n]
    for m in range(n):
        b[m] = a[m]


@helper
def fill(scratch: Array, at: int, n: int, value: float) -> None:
    """Set n cells."""
    cells = scratch[at : at + n]
    for j in range(n):
        cells[j] = value


@helper
def load_row(plane: Array, i: int, first: int, n: int, scratch: Array, at: int, whole: int) -> None:
    """Copy n cells of row i from column ``first`` on, on the other side of the torus where that leaves the grid.

    The cells up to ``whole`` become 0: left over, they would decay from pass to pass into subnormal numbers, which are
    slow to compute with.
    """
    rows, cols = plane.shape
    fill(scratch, at + n, whole - n, 0)
    if 0 <= i < rows and first >= 0 and first + n <= cols:
        move(plane[i], first, scratch, at, n)
        return
    row, to = plane[i % rows], scratch[at : at + n]
    for m in range(n):
        to[m] = row[(first + m) % cols]


@helper
def clip_rows(scratch: Array, at_x: int, at_y: int, n: int, rows: int) -> None:
    """Write the outputs of some rows."""
    one = scratch.dtype.type(1)
    for q in range(rows):
        first, to = at_x + q * STRIDE, at_y + q * STRIDE + PAD
        x, y = scratch[first : first + n], scratch[to : to + n]
        for j in range(n):
            v = x[j]
            v = one if v > one else v
            y[j] = -one if v < -one else v
