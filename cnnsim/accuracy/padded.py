"""Planes of a grid as flat arrays with virtual cells all round, so that a neighbour is a fixed distance away."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cnnsim.network import Boundary, Tap
from cnnsim.network.boundary import virtual_index
from cnnsim.support import Array, Flags, Floats, Integers


@dataclass(frozen=True)
class Padding:
    """A grid (rows, cols) with ``radius`` virtual cells all round, in one row of ``cells``.

    ``first`` .. ``last`` has all real cells, and virtual ones between their rows. ``virtual`` cells repeat the real
    ones of ``source``; ``heads`` and ``after`` list for each cell the virtual ones that repeat it, -1 ends a list.
    """

    shape: tuple[int, int]
    radius: int
    virtual: Integers
    source: Integers
    heads: Integers
    after: Integers

    @property
    def padded(self) -> tuple[int, int]:
        """Rows and columns with the virtual cells."""
        rows, cols = self.shape
        return rows + 2 * self.radius, cols + 2 * self.radius

    @property
    def first(self) -> int:
        """The first real cell."""
        return self.radius * self.padded[1] + self.radius

    @property
    def last(self) -> int:
        """One beyond the last real cell."""
        return (self.radius + self.shape[0]) * self.padded[1] - self.radius

    def real(self, flat: Any) -> Any:
        """Return the real cells (rows, cols) of a flat plane, as a view."""
        r = self.radius
        return flat.reshape(self.padded)[r : r + self.shape[0], r : r + self.shape[1]]

    def flat(self, plane: Array | float, around: float = 0.0) -> Floats:
        """Return a plane (rows, cols) as a flat one, with virtual cells that hold what they repeat, or a constant."""
        found = np.full(self.heads.size, around, np.float64)  # a boundary may be told as a whole number
        self.real(found)[...] = plane
        found[self.virtual] = found[self.source]
        return found

    def taps(self, taps: tuple[Tap, ...]) -> tuple[Integers, Floats]:
        """Return the distances to the neighbours, and their weights; three by three, filled up with weights of 0."""
        stride, fill = self.padded[1], [0] * (-len(taps) % 3)
        return np.array([k * stride + l for k, l, _ in taps] + fill), np.array([w for _, _, w in taps] + fill, float)

    def movable(self, mask: Flags | None) -> Flags:
        """Return which cells of a flat plane move."""
        found = np.zeros(self.heads.size, bool)
        self.real(found)[...] = True if mask is None else ~mask
        return found


@lru_cache(maxsize=16)
def padding(shape: tuple[int, int], radius: int, boundary: Boundary) -> Padding:
    """Return how a grid is laid out."""
    rows, cols = shape
    above, beside = virtual_index(rows, radius, boundary), virtual_index(cols, radius, boundary)
    stride = cols + 2 * radius
    stands_for = ((above[:, None] + radius) * stride + beside + radius).ravel()
    itself = np.arange(stands_for.size)
    virtual = np.flatnonzero((stands_for != itself) & (above[:, None] >= 0).repeat(stride, 1).ravel())
    if boundary.kind == "fixed":
        virtual = virtual[:0]
    source = stands_for[virtual]
    heads, after = np.full(itself.size, -1), np.full(itself.size, -1)
    for cell, real in zip(virtual.tolist(), source.tolist(), strict=True):
        after[cell], heads[real] = heads[real], cell
    return Padding((rows, cols), radius, virtual, source, heads, after)
