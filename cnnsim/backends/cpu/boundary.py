"""Virtual cells of inputs and packed planes in compiled loops; tiles set their own (`tiles.scratch` and others)."""

from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.cpu.compiled import helper
from cnnsim.network import Boundary
from cnnsim.network.boundary import virtual_index
from cnnsim.support import Array


class VirtualCells(NamedTuple):
    """Virtual cells up to ``r`` cells around a grid.

    ``rows`` and ``cols`` are the real rows and columns whose values positions -r, -r + 1, ... have (-1: ``constant``).
    """

    rows: Array
    cols: Array
    r: int
    constant: Any


def virtual_cells(shape: tuple[int, ...], r: int, boundary: Boundary, constant: Any) -> Any:
    """Return the `VirtualCells` of a grid as a plain tuple; ``constant`` has the dtype of the cells."""
    rows, cols = (virtual_index(cells, r, boundary) for cells in shape[-2:])
    return tuple(VirtualCells(rows, cols, r, constant))


@helper
def real_row(i: int, virtual: VirtualCells) -> Any:
    """Return the real row with the values of row i of the grid, -1 if there is none."""
    rows, _, r, _ = virtual
    return rows[i + r]


@helper
def cell(grid: Array, i: int, j: int, virtual: VirtualCells) -> Any:
    """Return a cell of a grid, real or virtual."""
    rows, cols, r, constant = virtual
    p, q = rows[i + r], cols[j + r]
    return constant if p < 0 or q < 0 else grid[p, q]


@helper
def packed_cell(grid: Array, i: int, j: int, virtual: VirtualCells) -> Any:
    """Return a cell of a packed grid, real or virtual, as a word that is 0 or 1."""
    rows, cols, r, constant = virtual
    p, q = rows[i + r], cols[j + r]
    if p < 0 or q < 0:
        return np.uint64(constant)
    return (grid[p, q // 64] >> np.uint64(q % 64)) & np.uint64(1)
