"""The scratch memory in which a thread steps tiles: its layout, and how rows get into it."""

from typing import NamedTuple

import numpy as np

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.rows import BLOCK, PAD, STRIDE
from cnnsim.support import Array

GROUP = 4 * BLOCK
"""Rows that a level of a tile steps at a time: what is kept of the last ones is copied once for all of them."""
SLACK = 16
"""Rows that stream past before the live ones are moved back to the start of their buffer."""


class TileLayout(NamedTuple):
    """Where things begin: live rows of x and w, two groups of y, the rows of y kept for each level, a drive,
    a row, and the numbers of the feedback. Other live rows come after those of w, each ``size`` cells after the last:
    the mask's if there is one, and of a scheme of some stages those of the stage, the sum, and rates that are kept.
    """

    x: int
    w: int
    size: int
    y: int
    new: int
    kept: int
    drive: int
    row: int
    numbers: int


@helper
def tile_cells(levels: int, r: int, lives: int) -> int:
    """Return the size of a thread's scratch for tiles of so many levels and sets of live rows."""
    return STRIDE * (lives * (levels * r + GROUP + SLACK) + 2 * (GROUP + 2 * r) + 2 * r * levels + GROUP + 2)


@helper
def tile_layout(scratch: Array, levels: int, r: int, lives: int) -> TileLayout:
    """Lay the buffers out, the first at the start of a cache line."""
    x = ((64 - (scratch.ctypes.data & 63)) & 63) // scratch.itemsize
    live, block = STRIDE * (levels * r + GROUP + SLACK), STRIDE * (GROUP + 2 * r)
    y = x + lives * live
    kept = y + 2 * block
    drive = kept + STRIDE * 2 * r * levels
    row = drive + STRIDE * GROUP
    return TileLayout(x, x + live, live, y, y + block, kept, drive, row, row + STRIDE)


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
def clear(scratch: Array, width: int) -> None:
    """Write 0 wherever tiles so many cells wide, with those around them, come to lie in their rows.

    Cells that nobody reads are computed beside the others, and of what the memory held before some are often subnormal
    numbers: with these a processor takes three times as long.
    """
    for row in range(0, scratch.size, STRIDE):
        fill(scratch, row, min(width + 4 * PAD, STRIDE, scratch.size - row), 0)


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
def load_bits(words: Array, i: int, first: int, n: int, cols: int, scratch: Array, at: int, whole: int) -> None:
    """Write 1 for black cells of row i of a packed plane, 0 for white ones; columns and rows as `load_row` has them."""
    fill(scratch, at + n, whole - n, 0)
    row, one, zero = words[i % words.shape[0]], scratch.dtype.type(1), scratch.dtype.type(0)
    begin, at_begin = first % cols, at
    while at_begin < at + n:
        word, bit = row[begin // 64], begin % 64
        count = min(64 - bit, cols - begin, at + n - at_begin)
        to = scratch[at_begin : at_begin + count]
        word >>= np.uint64(bit)
        for b in range(count):
            to[b] = one if (word >> np.uint64(b)) & np.uint64(1) else zero
        begin, at_begin = (begin + count) % cols, at_begin + count


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
