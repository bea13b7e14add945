"""Pressures that move with a rigid body: fields of them from tables by where they lie, or of all their cells."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.core.loads import COLUMNS, FORCE, PLACE, SHEAR
from tactile.elastic.disc_table import DEEPEST
from tactile.elastic.medium import Medium
from tactile.elastic.pattern_table import LARGEST, WIDTH, PatternTable, table_size
from tactile.simulator.contacts.fewer_points import fewer_points


def _ratio(depth: float, medium: Medium) -> float:
    return round(depth / medium.thickness, 12) if medium.thickness < DEEPEST * depth else 0.0


@dataclass(frozen=True, eq=False)
class LoadPattern:
    """Shares of a body's load on cells of one pitch, at some levels of its force.

    ``places`` (cells, 2) [m] from the body's middle; ``shares`` (levels, cells), each level's sum 1; ``pitch`` [m];
    ``depth`` [m] and ``medium``: what `fewer` is for. ``memory``: tables already made.
    """

    places: Floats
    shares: Floats
    pitch: float
    depth: float
    medium: Medium
    memory: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def fewer(self) -> tuple[Floats, Floats]:
        """Places (n, 2) [m] and shares (levels, n) that taxels can hardly tell from those of all cells."""
        places, shares = fewer_points(self.places, self.shares, self.depth, self.medium)
        return places, shares / shares.sum(axis=1, keepdims=True)

    def fits(self, depth: float, medium: Medium, accuracy: float) -> bool:
        """Whether there are tables so fine for taxels at a depth [m]: not of a contact many depths wide."""
        wide, high = (np.ptp(self.places, axis=0) / depth).tolist()
        return table_size(wide, high, _ratio(depth, medium), medium.nu, medium.quantity, accuracy) <= LARGEST

    def table(self, level: int, depth: float, medium: Medium, accuracy: float, columns: int) -> PatternTable:
        """The table of one level, made once."""
        key = level, depth, replace(medium, modulus=1.0), accuracy, columns
        if key not in self.memory:
            low = self.places.min(axis=0)
            col, row = np.rint((self.places - low) / self.pitch).astype(int).T
            image = np.zeros((row.max() + 1, col.max() + 1))
            image[row, col] = self.shares[level]
            x, y = ((low + np.array(image.shape[::-1]) * self.pitch / 2 - self.pitch / 2) / depth).tolist()
            cover = _ratio(depth, medium), medium.nu, medium.quantity
            self.memory[key] = PatternTable(image, (x, y), self.pitch / depth, *cover, accuracy, columns)
        made: PatternTable = self.memory[key]
        return made


@dataclass(frozen=True, eq=False)
class PatternLoads:
    """A pattern over some frames: ``rows`` (frames, 5) (x, y, Q, R, F), ``owner`` (1,) contact.

    Of a frame's load the shares ``weights`` (frames, 2), sum 1, are spread as at the levels ``first`` (frames,) and the
    next.
    """

    pattern: LoadPattern
    rows: Floats
    first: Integers
    weights: Floats
    owner: Integers

    def of_frames(self, part: slice) -> "PatternLoads":
        """Those of some of the frames."""
        return replace(self, rows=self.rows[part], first=self.first[part], weights=self.weights[part])

    def points(self, fewer: bool = False) -> Floats:
        """All cells as point loads (frames, cells, 5), or ``fewer`` that feel like them."""
        pattern = self.pattern
        places, shares = pattern.fewer if fewer else (pattern.places, pattern.shares)
        out = np.empty((len(self.rows), len(places), COLUMNS))
        share = self.weights[:, :1] * shares[self.first] + self.weights[:, 1:] * shares[self.first + 1]
        out[..., PLACE] = self.rows[:, None, PLACE] + places
        out[..., FORCE] = self.rows[:, None, FORCE] * share[..., None]
        return out

    def add(self, out: Floats, positions: Floats, depth: float, medium: Medium, accuracy: float) -> None:
        """Add to ``out`` (frames, taxels, 3) what taxels at ``positions`` (taxels, 2) [m] feel, from tables."""
        from tactile.elastic.pattern_loops import add_pattern  # compiled only where called for

        columns = WIDTH[int(self.rows[:, SHEAR].any())]
        rows = self.rows.copy()
        rows[:, PLACE] /= depth
        rows[:, FORCE] /= depth**2 if medium.quantity == "stress" else medium.modulus * depth**2
        at, pressing = positions / depth, self.rows[:, FORCE].any(axis=1)
        if not pressing.any() or not len(at):
            return
        places = rows[pressing, PLACE]
        ends = at.max(axis=0) - places.min(axis=0), places.max(axis=0) - at.min(axis=0)
        farthest = float(np.max(ends))
        for level in np.unique([self.first, self.first + 1]).tolist():
            lower, upper = self.first == level, self.first + 1 == level
            weights = np.where(lower, self.weights[:, 0], np.where(upper, self.weights[:, 1], 0.0))
            frames = np.flatnonzero(pressing & (weights > 0))
            if frames.size:
                table = self.pattern.table(level, depth, medium, accuracy, columns)
                table.reach(farthest)
                add_pattern(out, at, rows, frames, weights[frames], table.numbers, table.grids, columns)
