"""Surface of a height map between its cells: smooth, with walls where heights jump."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.elastic.medium import Medium
from tactile.elastic.rough_contact import RoughContact

WALL = 4.0
"""Ratio of a rise between two cells to both neighbouring rises that makes it a wall: on a parabola, a cone, a ramp or a
rounded edge one neighbour at least is of its size."""

PARTS = 4
"""Samples of the surface in a cell, along each axis, to find where it can touch."""
AROUND = 4
"""Cells to each side on which the surface in a cell depends."""


@dataclass(frozen=True, eq=False)
class HeightSurface:
    """A map's surface: ``heights`` (rows, cols) [m], cells of a ``pitch`` [m]."""

    heights: Floats
    pitch: float

    @cached_property
    def _least(self) -> Floats:
        """The lowest height in every cell."""
        rows, cols = self.heights.shape
        return np.asarray(refined(self.heights, PARTS).reshape(rows, PARTS, cols, PARTS).min(axis=(1, 3)))

    @cached_property
    def lowest(self) -> float:
        """The lowest height, also between the cells' middles, to a thousandth of a parabola's rise per cell."""
        row, col = (int(n) for n in np.unravel_index(self._least.argmin(), self.heights.shape))
        box = max(row - 1, 0), min(row + 2, self.heights.shape[0]), max(col - 1, 0), min(col + 2, self.heights.shape[1])
        return min(float(self._least.min()), float(SurfaceGrid(self, 8 * PARTS, *box).heights.min()))

    def grid(self, deep: float, parts: int, more: int = 1) -> "SurfaceGrid":
        """Return the area that can touch at an indentation [m] with ``more`` cells around, ``parts`` per cell and axis.

        A layer bulges around a contact and may touch there.
        """
        ends = touching(self._least - self.lowest < deep, more)
        return SurfaceGrid(self, parts, *(end for one in ends for end in (one.start, one.stop)))

    def pressed(self, deep: float, parts: int, medium: Medium) -> tuple["SurfaceGrid", RoughContact, Floats]:
        """Return pressures [Pa] at an indentation [m] on ``parts`` of cells, on a grid that contains the contact."""
        more = 1
        while True:
            grid = self.grid(deep, parts, more)
            contact = grid.contact(medium)
            pressure = contact.pressed(deep)
            if not grid.cuts(pressure > 0):
                return grid, contact, pressure
            more *= 2

    def force(self, deep: float, parts: int, medium: Medium) -> float:
        """Return the force [N] at an indentation [m], on ``parts`` of cells."""
        grid, _, pressure = self.pressed(deep, parts, medium)
        return float(pressure.sum()) * grid.pitch**2


def touching(touches: Flags, more: int) -> tuple[slice, slice]:
    """Return the rows and columns of cells that can touch with ``more`` to each side, all where there are none."""
    rows, cols = (np.flatnonzero(touches.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return slice(0, touches.shape[0]), slice(0, touches.shape[1])
    first, second = (
        slice(max(int(at[0]) - more, 0), min(int(at[-1]) + 1 + more, count))
        for at, count in zip((rows, cols), touches.shape, strict=True)
    )
    return first, second


@dataclass(frozen=True, eq=False)
class SurfaceGrid:
    """Parts of cells over a box of a map: rows ``top`` to ``bottom``, columns ``left`` to ``right``."""

    surface: HeightSurface
    parts: int
    top: int
    bottom: int
    left: int
    right: int

    @property
    def pitch(self) -> float:
        """Pitch of its cells [m]."""
        return self.surface.pitch / self.parts

    @property
    def size(self) -> int:
        """The number of its cells."""
        return (self.bottom - self.top) * (self.right - self.left) * self.parts**2

    @property
    def heights(self) -> Floats:
        """Heights of the middles of its cells [m]."""
        top, left = max(self.top - AROUND, 0), max(self.left - AROUND, 0)
        fine = refined(self.surface.heights[top : self.bottom + AROUND, left : self.right + AROUND], self.parts)
        rows, cols = (
            slice((low - first) * self.parts, (high - first) * self.parts)
            for first, low, high in ((top, self.top, self.bottom), (left, self.left, self.right))
        )
        return fine[rows, cols]

    def contact(self, medium: Medium) -> RoughContact:
        """Return the contact problem of this part of the surface."""
        return RoughContact(self.heights, self.pitch, medium, self.surface.lowest)

    def cuts(self, pressed: Flags) -> bool:
        """Return whether a contact reaches an edge beyond which the map continues."""
        rows, cols = self.surface.heights.shape
        ends = self.top > 0, self.bottom < rows, self.left > 0, self.right < cols
        sides = pressed[0], pressed[-1], pressed[:, 0], pressed[:, -1]
        return any(open_ and side.any() for open_, side in zip(ends, sides, strict=True))

    def places(self, pressed: Flags) -> Floats:
        """Return the middles (n, 2) [m] of the pressed cells, from the map's middle."""
        y, x = np.nonzero(pressed)
        rows, cols = self.surface.heights.shape
        first = np.array([self.left - cols / 2, self.top - rows / 2]) * self.surface.pitch
        return np.asarray(first + (np.stack([x, y], axis=-1) + 0.5) * self.pitch)


def refined(heights: Floats, parts: int) -> Floats:
    """Return heights (rows * parts, cols * parts) in the middles of parts of cells, from those of cells (rows, cols).

    Along the columns, then the rows: cubics through the cells' middles, of the fourth order where it is smooth, exact
    on parabolas, without overshoot at kinks. Half-way to a wall, and at the border, the surface ends as the
    parabola of its own side, level where that has its extremum there.

    Source: Huynh, Accurate Monotone Cubic Interpolation (1993), his M3-A, for the slopes.
    """
    if parts == 1:
        return heights.copy()
    wide = _along(heights, parts)
    return np.ascontiguousarray(_along(np.ascontiguousarray(wide.T), parts).T)


def _along(heights: Floats, parts: int) -> Floats:
    """Return heights refined along the last axis."""
    count = heights.shape[-1]
    if count == 1:
        return np.repeat(heights, parts, axis=-1)
    rise = np.diff(heights, axis=-1)
    edge, none = np.ones((*heights.shape[:-1], 1), bool), np.zeros((*heights.shape[:-1], 1))
    wall = _walls(rise)
    ends_before, ends_after = np.concatenate([edge, wall], axis=-1), np.concatenate([wall, edge], axis=-1)
    before, after = np.concatenate([none, rise], axis=-1), np.concatenate([rise, none], axis=-1)
    inner = ~ends_before & ~ends_after
    bend = np.where(inner, after - before, 0.0)
    # the second difference between two cells: the smaller of both, or the only one
    own, others = bend[..., :-1], bend[..., 1:]
    between = np.where(inner[..., 1:], np.where(inner[..., :-1], _smaller(own, others), others), own)
    bend_before = np.concatenate([none, between], axis=-1)
    bend_after = np.concatenate([between, none], axis=-1)
    slope_before, slope_after = before + bend_before / 2, after - bend_after / 2
    # a surface that alternates from cell to cell is not extrapolated
    inwards = np.where(ends_before, after * np.roll(after, -1, axis=-1), before * np.roll(before, 1, axis=-1))
    steady = (inwards > 0) & ~(ends_before & ends_after)
    slope = np.where(steady, np.where(ends_before, slope_after, slope_before), 0.0)
    slope = np.where(inner, _limited(before, after, slope_before, slope_after, inner), slope)
    going_on = np.where(steady, np.where(ends_before, bend_after, bend_before), 0.0)
    out = np.empty((*heights.shape, parts))
    for part, step in enumerate(((np.arange(parts) + 0.5) / parts - 0.5).tolist()):
        ends, other = (
            (ends_before, np.roll(heights, 1, axis=-1)) if step < 0 else (ends_after, np.roll(heights, -1, -1))
        )
        leaning = np.roll(slope, 1 if step < 0 else -1, axis=-1)
        s, turned = abs(step), -1.0 if step < 0 else 1.0
        cubic = (
            (1 + 2 * s) * (1 - s) ** 2 * heights
            + s**2 * (3 - 2 * s) * other
            + turned * (s * (1 - s) ** 2 * slope - s**2 * (1 - s) * leaning)
        )
        out[..., part] = np.where(ends, heights + slope * step + going_on * step**2 / 2, cubic)
    return out.reshape(*heights.shape[:-1], count * parts)


def _limited(before: Floats, after: Floats, slope_before: Floats, slope_after: Floats, inner: Flags) -> Floats:
    """Return slopes of the fourth order, of the second next to an end, limited so that nothing overshoots at a kink."""
    wide = inner.copy()
    wide[..., 1:] &= inner[..., :-1]
    wide[..., :-1] &= inner[..., 1:]
    aside = np.roll(before, 1, axis=-1) + np.roll(after, -1, axis=-1)
    slope = np.where(wide, (7 * (before + after) - aside) / 12, (before + after) / 2)
    steep, bent = _smaller(before, after), _smaller(slope_before, slope_after)
    return _smaller(slope, np.sign(bent) * np.maximum(3 * np.abs(steep), 1.5 * np.abs(bent)))


def _walls(rise: Floats) -> Flags:
    """Return which rises (..., n) between cells are walls; beyond the border rises are extrapolated."""
    size = np.abs(rise)
    if rise.shape[-1] < 3:
        return np.zeros(rise.shape, bool)
    first, last = np.abs(2 * rise[..., 1:2] - rise[..., 2:3]), np.abs(2 * rise[..., -2:-1] - rise[..., -3:-2])
    before = np.concatenate([first, size[..., :-1]], axis=-1)
    after = np.concatenate([size[..., 1:], last], axis=-1)
    return np.asarray(size > WALL * np.maximum(before, after))


def _smaller(one: Floats, other: Floats) -> Floats:
    """Return the value nearer to zero, 0 where the signs differ."""
    return np.where(one * other > 0, np.where(np.abs(one) < np.abs(other), one, other), 0.0)
