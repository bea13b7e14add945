"""The buffers of a tile: how they lie in one thread's room, and how rows and virtual cells get into them."""

from typing import Any, NamedTuple

from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import helper
from cnnsim.backends.cpu_rows import BLOCK, PAD, STRIDE

Array = NDArray[Any]

FIXED, ZERO_FLUX, PERIODIC = 0, 1, 2
SLACK = 32
"""Rows that stream past before the live ones are moved back to the start of their buffer."""


class Scratch(NamedTuple):
    """Buffers of one thread: live rows of x and w, two blocks of y, rows of y kept for each level, a drive, a row."""

    x: Array
    w: Array
    y: Array
    new: Array
    kept: Array
    drive: Array
    row: Array


@helper
def scratch_cells(depth: int, r: int) -> int:
    """Return the cells of one thread's buffers for tiles of this depth."""
    return STRIDE * (2 * (depth * r + BLOCK + SLACK) + 2 * (BLOCK + 2 * r) + 2 * r * depth + BLOCK + 2)


@helper
def divide(room: Array, depth: int, r: int) -> Scratch:
    """Cut one thread's room into its buffers, starting at a cache line."""
    start = (64 - (room.ctypes.data & 63)) // room.itemsize
    live, block = STRIDE * (depth * r + BLOCK + SLACK), STRIDE * (BLOCK + 2 * r)
    y, kept = start + 2 * live, start + 2 * live + 2 * block
    drive = kept + STRIDE * 2 * r * depth
    row = drive + STRIDE * BLOCK
    return Scratch(
        room[start : start + live], room[start + live : y], room[y : y + block], room[y + block : kept],
        room[kept:drive], room[drive:row], room[row : row + STRIDE],
    )  # fmt: skip


@helper
def move(source: Array, i: int, target: Array, j: int, n: int) -> None:
    """Copy n cells; a loop, because an assignment of slices costs numba a check for overlap ten times as dear."""
    a, b = source[i : i + n], target[j : j + n]
    for m in range(n):
        b[m] = a[m]


@helper
def load_row(plane: Array, i: int, first: int, n: int, target: Array, at: int) -> None:
    """Copy n cells of row i from column ``first`` on, around the torus where that leaves the grid."""
    rows, cols = plane.shape
    if 0 <= i < rows and first >= 0 and first + n <= cols:
        move(plane[i], first, target, at, n)
        return
    row, to = plane[i % rows], target[at : at + n]
    for m in range(n):
        to[m] = row[(first + m) % cols]


@helper
def clip_block(x: Array, y: Array, n: int) -> None:
    """Write the outputs of a block."""
    one = x.dtype.type(1)
    for q in range(BLOCK):
        row, to = x[q * STRIDE : q * STRIDE + n], y[q * STRIDE + PAD : q * STRIDE + PAD + n]
        for j in range(n):
            v = row[j]
            v = one if v > one else v
            to[j] = -one if v < -one else v


@helper
def set_virtual(
    y: Array, i0: int, rows: int, n: int, used: int, left: bool, right: bool, r: int, kind: int, c: float
) -> None:
    """Set the virtual cells of a block of y: its rows from 2r on are the grid's rows i0 .. i0 + 3.

    ``left`` and ``right``: whether the block reaches the grid's first or last column. Rows above the grid are the r
    rows before row 0, still in the block when row 0 comes.
    """
    for q in range(BLOCK):
        o, i = (q + 2 * r) * STRIDE, i0 + q
        if i >= rows and kind == ZERO_FLUX:
            move(y, o - STRIDE, y, o, used)
        elif i >= rows:
            y[o : o + used].fill(c)
        if left:
            y[o + PAD - r : o + PAD].fill(y[o + PAD] if kind == ZERO_FLUX else c)
        if right:
            end = o + PAD + n
            y[end : end + r].fill(y[end - 1] if kind == ZERO_FLUX else c)
        if i == 0:
            for p in range(1, r + 1):
                if kind == ZERO_FLUX:
                    move(y, o, y, o - p * STRIDE, used)
                else:
                    y[o - p * STRIDE : o - p * STRIDE + used].fill(c)
