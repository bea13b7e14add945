"""The buffers of a tile: how they lie in one thread's room, and how rows and virtual cells get into them."""

from typing import NamedTuple

from cnnsim.backends.cpu.euler.rows import BLOCK, PAD, STRIDE
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array

FIXED, ZERO_FLUX, PERIODIC = 0, 1, 2
GROUP = 4 * BLOCK
"""Rows that a level of a tile steps at a time: what is kept of the last ones is copied once for all of them."""
SLACK = 16
"""Rows that stream past before the live ones are moved back to the start of their buffer."""


class Places(NamedTuple):
    """Where things begin in a room: live rows of x and w, two groups of y, the rows of y kept for each level, a drive,
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
def room_cells(depth: int, r: int) -> int:
    """Return the size of one thread's room for tiles of this depth."""
    return STRIDE * (2 * (depth * r + GROUP + SLACK) + 2 * (GROUP + 2 * r) + 2 * r * depth + GROUP + 2)


@helper
def divide(room: Array, depth: int, r: int) -> Places:
    """Give each thing its place, the first at the start of a cache line."""
    x = ((64 - (room.ctypes.data & 63)) & 63) // room.itemsize
    live, block = STRIDE * (depth * r + GROUP + SLACK), STRIDE * (GROUP + 2 * r)
    y = x + 2 * live
    kept = y + 2 * block
    drive = kept + STRIDE * 2 * r * depth
    row = drive + STRIDE * GROUP
    return Places(x, x + live, y, y + block, kept, drive, row, row + STRIDE)


@helper
def move(source: Array, i: int, target: Array, j: int, n: int) -> None:
    """Copy n cells; a loop, because an assignment of slices costs numba a check for overlap ten times as dear."""
    a, b = source[i : i + n], target[j : j + n]
    for m in range(n):
        b[m] = a[m]


@helper
def fill(room: Array, at: int, n: int, value: float) -> None:
    """Set n cells."""
    cells = room[at : at + n]
    for j in range(n):
        cells[j] = value


@helper
def load_row(plane: Array, i: int, first: int, n: int, room: Array, at: int, whole: int) -> None:
    """Copy n cells of row i from column ``first`` on, around the torus where that leaves the grid.

    The cells up to ``whole`` become 0: left over, they would decay from pass to pass into subnormal numbers, which are
    slow to compute with.
    """
    rows, cols = plane.shape
    fill(room, at + n, whole - n, 0)
    if 0 <= i < rows and first >= 0 and first + n <= cols:
        move(plane[i], first, room, at, n)
        return
    row, to = plane[i % rows], room[at : at + n]
    for m in range(n):
        to[m] = row[(first + m) % cols]


@helper
def clip_rows(room: Array, at_x: int, at_y: int, n: int, rows: int) -> None:
    """Write the outputs of some rows."""
    one = room.dtype.type(1)
    for q in range(rows):
        first, to = at_x + q * STRIDE, at_y + q * STRIDE + PAD
        x, y = room[first : first + n], room[to : to + n]
        for j in range(n):
            v = x[j]
            v = one if v > one else v
            y[j] = -one if v < -one else v


@helper
def set_virtual(
    room: Array, at: int, i0: int, rows: int, n: int, left: bool, right: bool, r: int, kind: int, c: float
) -> None:
    """Set the virtual cells of a group of rows of y: its rows from 2r on are the grid's rows from i0 on, n columns.

    ``left`` and ``right``: whether the rows reach the grid's first or last column. Rows above the grid are the r
    rows before row 0, still in the group when row 0 comes.
    """
    used = n + 2 * PAD
    for q in range(GROUP):
        o, i = at + (q + 2 * r) * STRIDE, i0 + q
        if i >= rows and kind == ZERO_FLUX:
            move(room, o - STRIDE, room, o, used)
        elif i >= rows:
            fill(room, o, used, c)
        if left:
            v = room[o + PAD] if kind == ZERO_FLUX else c
            for p in range(o + PAD - r, o + PAD):
                room[p] = v
        if right:
            end = o + PAD + n
            v = room[end - 1] if kind == ZERO_FLUX else c
            for p in range(end, end + r):
                room[p] = v
        if i == 0:
            for p in range(1, r + 1):
                if kind == ZERO_FLUX:
                    move(room, o, room, o - p * STRIDE, used)
                else:
                    fill(room, o - p * STRIDE, used, c)
