"""Virtual cells of the loops over tiles: how they are set while rows are in the cache."""

from cnnsim.backends.codes import BoundaryCode
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.grid import Edge
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.backends.cpu.tiles.scratch import GROUP, fill, move
from cnnsim.support import Array

ZERO_FLUX, PERIODIC = int(BoundaryCode.ZERO_FLUX), int(BoundaryCode.PERIODIC)


@helper
def is_periodic(edge: Edge) -> bool:
    """Return whether rows and columns go on at the other side, from where `load_row` takes them."""
    _, code, _ = edge
    return code == PERIODIC


@helper
def set_virtual(scratch: Array, at: int, i0: int, rows: int, n: int, sides: tuple[bool, bool], edge: Edge) -> None:
    """Set the virtual cells of a group of rows of y: its rows from 2r on are the grid's rows from i0 on, n columns.

    ``sides``: whether the rows reach the grid's first and last column. Rows above the grid are the r rows before row 0,
    still in the group when row 0 comes.
    """
    used = n + 2 * PAD
    left, right = sides
    r, code, c = edge
    for q in range(GROUP):
        o, i = at + (q + 2 * r) * STRIDE, i0 + q
        if i >= rows and code == ZERO_FLUX:
            move(scratch, o - STRIDE, scratch, o, used)
        elif i >= rows:
            fill(scratch, o, used, c)
        if left:
            v = scratch[o + PAD] if code == ZERO_FLUX else c
            for p in range(o + PAD - r, o + PAD):
                scratch[p] = v
        if right:
            end = o + PAD + n
            v = scratch[end - 1] if code == ZERO_FLUX else c
            for p in range(end, end + r):
                scratch[p] = v
        if i == 0:
            for p in range(1, r + 1):
                if code == ZERO_FLUX:
                    move(scratch, o, scratch, o - p * STRIDE, used)
                else:
                    fill(scratch, o - p * STRIDE, used, c)


@helper
def set_edges(scratch: Array, y: int, m: int, n: int, sides: tuple[bool, bool, bool, bool], edge: Edge) -> None:
    """Set the virtual cells round m x n cells whose first row is row r of y, on the sides that are the grid's own.

    ``sides`` are top, bottom, left and right.
    """
    top, bottom, left, right = sides
    r, code, c = edge
    if left or right:
        for p in range(r, r + m):
            o = y + p * STRIDE + PAD
            if left:
                fill(scratch, o - r, r, scratch[o] if code == ZERO_FLUX else c)
            if right:
                fill(scratch, o + n, r, scratch[o + n - 1] if code == ZERO_FLUX else c)
    for p in range(r):
        for there, row, nearest in ((top, p, r), (bottom, r + m + p, r + m - 1)):
            if there and code == ZERO_FLUX:
                move(scratch, y + nearest * STRIDE, scratch, y + row * STRIDE, n + 2 * PAD)
            elif there:
                fill(scratch, y + row * STRIDE, n + 2 * PAD, c)
