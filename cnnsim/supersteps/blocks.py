"""Blocks of a grid: their areas, their halos with the wrap of a torus, and reading of cells from Zarr arrays."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from cnnsim.network import Boundary
from cnnsim.support import Array, Integers

Span = tuple[int, int]
"""Rows or columns [first, after)."""
Area = tuple[Span, Span]


@dataclass(frozen=True)
class Blocks:
    """A grid (rows, cols) cut into squares of ``side`` cells, the last ones smaller, numbered row by row."""

    shape: tuple[int, int]
    side: int
    boundary: Boundary

    def __len__(self) -> int:
        return self.counts[0] * self.counts[1]

    @cached_property
    def counts(self) -> tuple[int, int]:
        """Number of blocks down and across."""
        return math.ceil(self.shape[0] / self.side), math.ceil(self.shape[1] / self.side)

    def area(self, block: int) -> Area:
        """Return the rows and columns of a block."""
        spans = [
            (number * self.side, min((number + 1) * self.side, cells))
            for number, cells in zip(divmod(block, self.counts[1]), self.shape, strict=True)
        ]
        return spans[0], spans[1]

    def around(self, block: int, halo: int) -> tuple[Integers, Integers, Area]:
        """Return the rows and the columns of a block with a halo, and the area of the block among them.

        With a periodic boundary the halo wraps around; otherwise it ends at the edge of the grid.
        """
        found, inside = [], []
        for (first, after), cells in zip(self.area(block), self.shape, strict=True):
            if self.boundary.kind == "periodic":
                index, low = np.arange(first - halo, after + halo) % cells, first - halo
            else:
                index, low = np.arange(max(first - halo, 0), min(after + halo, cells)), max(first - halo, 0)
            found.append(index)
            inside.append((first - low, after - low))
        return found[0], found[1], (inside[0], inside[1])


def read_cells(array: Any, rows: Integers, cols: Integers) -> Array:
    """Return the cells of a Zarr array in these rows and columns, read as slices."""
    down, across = _slices(rows), _slices(cols)
    if len(down) == len(across) == 1:
        return array[..., slice(*down[0][1]), slice(*across[0][1])]
    out = np.empty((*array.shape[:-2], len(rows), len(cols)), array.dtype)
    for (p0, p1), (r0, r1) in down:
        for (q0, q1), (c0, c1) in across:
            out[..., p0:p1, q0:q1] = array[..., r0:r1, c0:c1]
    return out


def _slices(index: Integers) -> list[tuple[Span, Span]]:
    """Return (positions, cells) of each run of consecutive cells in an index."""
    edges = [0, *(np.flatnonzero(np.diff(index) != 1) + 1).tolist(), len(index)]
    return [((a, b), (int(index[a]), int(index[b - 1]) + 1)) for a, b in pairwise(edges)]
