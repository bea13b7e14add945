"""Blocks of a grid: their areas, and what lies around them, with the wrap of a torus."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

import numpy as np

from cnnsim.network import Boundary
from cnnsim.support import Integers

Span = tuple[int, int]
"""Rows or columns [first, after)."""
Area = tuple[Span, Span]


@dataclass(frozen=True)
class Blocks:
    """A grid (rows, cols) cut into squares of ``side``, those at its end smaller, counted row by row."""

    shape: tuple[int, int]
    side: int
    boundary: Boundary

    def __len__(self) -> int:
        return self.counts[0] * self.counts[1]

    @cached_property
    def counts(self) -> tuple[int, int]:
        """How many blocks there are down and across."""
        return math.ceil(self.shape[0] / self.side), math.ceil(self.shape[1] / self.side)

    def area(self, block: int) -> Area:
        """Return the rows and columns of a block."""
        down, across = divmod(block, self.counts[1])
        return self._span(down, 0), self._span(across, 1)

    def _span(self, number: int, axis: int) -> Span:
        return number * self.side, min((number + 1) * self.side, self.shape[axis])

    def around(self, block: int, halo: int) -> tuple[Integers, Integers, Area]:
        """Return the rows and the columns of a block with a halo, as real cells, and where the block lies among them.

        On a torus the halo goes round, as often as it must; elsewhere it ends at the edge of the grid, where the
        boundary's virtual cells begin.
        """
        found, inside = [], []
        for (first, after), cells in zip(self.area(block), self.shape, strict=True):
            index, low = self._widened(first - halo, after + halo, cells)
            found.append(index)
            inside.append((first - low, after - low))
        return found[0], found[1], (inside[0], inside[1])

    def _widened(self, low: int, high: int, cells: int) -> tuple[Integers, int]:
        if self.boundary.kind == "periodic":
            return np.arange(low, high) % cells, low
        return np.arange(max(low, 0), min(high, cells)), max(low, 0)

    def reached(self, area: Area, halo: int) -> set[int]:
        """Return the blocks with cells in an area, or so near to it."""
        spans = zip(area, self.shape, strict=True)
        rows, cols = (self._widened(first - halo, after + halo, cells)[0] for (first, after), cells in spans)
        return self.touched(rows, cols)

    def touched(self, rows: Integers, cols: Integers) -> set[int]:
        """Return the blocks that have cells in these rows and columns."""
        down, across = (np.unique(index // self.side) for index in (rows, cols))
        return {int(i) * self.counts[1] + int(j) for i, j in product(down, across)}


def runs(index: Integers, side: int) -> list[tuple[Span, Span]]:
    """Return (places, cells) of the stretches of an index that follow one another; ``side`` > 0: cut at block edges."""
    jumps = np.diff(index) != 1
    if side:
        jumps |= index[1:] % side == 0
    edges = [0, *(np.flatnonzero(jumps) + 1).tolist(), len(index)]
    return [((a, b), (int(index[a]), int(index[b - 1]) + 1)) for a, b in pairwise(edges)]
