"""Pressures that move with a rigid body: fields of them from tables by where they lie, or of all their cells."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.core.loads import COLUMNS, FORCE, PLACE, SHEAR, F, Q, R
from tactile.elastic.medium import Medium
from tactile.elastic.pattern_table import LARGEST, WIDTH, PatternTable, depth_ratio, table_size
from tactile.simulator.contacts.fewer_points import fewer_points

STAYS = 2
"""Frames for each level and kind of force, more than which a body that stays in place gives: else each is felt."""
AT_ONCE = 1 << 20
"""Loads, times taxels and frames, that are summed at once."""


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
        return table_size(wide, high, depth_ratio(depth, medium), medium.nu, medium.quantity, accuracy) <= LARGEST

    def table(self, level: int, depth: float, medium: Medium, accuracy: float, columns: int) -> PatternTable:
        """The table of one level, made once."""
        key = level, depth, replace(medium, modulus=1.0), accuracy, columns
        if key not in self.memory:
            low = self.places.min(axis=0)
            col, row = np.rint((self.places - low) / self.pitch).astype(int).T
            image = np.zeros((row.max() + 1, col.max() + 1))
            image[row, col] = self.shares[level]
            x, y = ((low + np.array(image.shape[::-1]) * self.pitch / 2 - self.pitch / 2) / depth).tolist()
            cover = depth_ratio(depth, medium), medium.nu, medium.quantity
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

    def spread(self, frame: int) -> float:
        """The mean square [m^2] of how far from the body's middle its load acts in a frame."""
        level = self.first[frame]
        squares = self.pattern.shares[level : level + 2] @ (self.pattern.places**2).sum(axis=1)
        return float(self.weights[frame, : len(squares)] @ squares)

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

    def add(self, out: Floats, feel: "Feel", of: Any) -> None:
        """Add to ``out`` (frames, taxels, 3) what they feel, as ``feel`` adds it, which depends on ``of`` besides.

        Of a body that stays in place once for each level and kind of force, not for each frame, and kept.
        """
        both = np.concatenate([np.column_stack([self.rows[:, PLACE], self.first + k]) for k in (0, 1)])
        units, which = np.unique(both, axis=0, return_inverse=True)
        kinds = [F] if not self.rows[:, SHEAR].any() else [Q, R, F]
        if STAYS * len(kinds) * len(units) >= len(out):
            feel(self, out)
            return
        now: dict[bytes, Floats] = {}
        known, felt = self.pattern.memory.get(of, {}), np.empty((len(units), len(kinds), *out.shape[1:]))
        for unit, one in zip(units, felt, strict=True):
            key = np.append(unit, len(kinds)).tobytes()
            if key not in known:
                known[key] = np.zeros_like(one)
                feel(self._alone(unit, kinds), known[key])
            one[:] = now[key] = known[key]
        # of one that moves on what was found is not kept
        self.pattern.memory[of] = known if len(known) * felt[0].size <= LARGEST else now
        for k, index in enumerate(which.reshape(2, -1)):
            out += np.einsum("fd,fd...->f...", self.weights[:, k, None] * self.rows[:, kinds], felt[index])

    def _alone(self, unit: Floats, kinds: list[int]) -> "PatternLoads":
        """Frames of 1 N each of these kinds of force, the pattern at one place and level (x, y, level)."""
        rows, count, level = np.zeros((len(kinds), COLUMNS)), len(kinds), int(unit[2])
        rows[:, PLACE], rows[range(count), kinds] = unit[:2], 1.0
        first = min(level, len(self.pattern.shares) - 2)
        weights = np.tile((first + 1.0 - level, level - 1.0 * first), (count, 1))
        return replace(self, rows=rows, first=np.full(count, first), weights=weights)


Feel = Callable[[PatternLoads, Floats], None]
"""Adds what taxels feel of loads to an array (frames, taxels, 3)."""


def add_cells(loads: PatternLoads, out: Floats, summed: Callable[[Floats], Floats]) -> None:
    """Add what taxels feel of all cells, load by load: ``summed`` of point loads (frames, n, 5)."""
    step = max(1, AT_ONCE // (out.shape[1] * len(loads.pattern.places)))
    for start in range(0, len(out), step):
        part = slice(start, start + step)
        out[part] += summed(loads.of_frames(part).points())


def add_tabled(
    loads: PatternLoads, out: Floats, positions: Floats, depth: float, medium: Medium, accuracy: float
) -> None:
    """Add what taxels at ``positions`` (taxels, 2) [m] and a depth [m] feel, from tables."""
    from tactile.elastic.pattern_loops import add_pattern  # compiled only where called for

    at, rows, pressing = positions / depth, loads.rows.copy(), loads.rows[:, FORCE].any(axis=1)
    if not pressing.any() or not len(at):
        return
    rows[:, PLACE] /= depth
    rows[:, FORCE] /= depth**2 if medium.quantity == "stress" else medium.modulus * depth**2
    columns, places = WIDTH[int(rows[:, SHEAR].any())], rows[pressing, PLACE]
    farthest = float(np.max([at.max(axis=0) - places.min(axis=0), places.max(axis=0) - at.min(axis=0)]))
    for level in np.unique([loads.first, loads.first + 1]).tolist():
        lower, upper = loads.first == level, loads.first + 1 == level
        weights = np.where(lower, loads.weights[:, 0], np.where(upper, loads.weights[:, 1], 0.0))
        frames = np.flatnonzero(pressing & (weights > 0))
        if frames.size:
            table = loads.pattern.table(level, depth, medium, accuracy, columns)
            table.reach(farthest)
            add_pattern(out, at, rows, frames, weights[frames], table.numbers, table.grids, columns)
