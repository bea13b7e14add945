"""Pressures that move with a rigid body: point loads on all cells, or on fewer that give taxels the same field."""

from dataclasses import dataclass, field, replace

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.core.loads import COLUMNS, FORCE, PLACE
from tactile.simulator.contacts.equivalent_points import equivalent_points

ALL_CELLS = 1e-5
"""Finest accuracy of equivalent points; at finer ones all cells are summed."""
COARSE = 1e-3
"""Accuracy of the loads where no field is computed of them."""


@dataclass(frozen=True, eq=False)
class LoadPattern:
    """Shares of a body's load on cells, at some levels of its force.

    ``places`` (cells, 2) [m] from the body's middle; ``shares`` (levels, cells), each level's sum 1; ``depth`` of the
    taxels [m]. ``memory``: points of an accuracy, once computed.
    """

    places: Floats
    shares: Floats
    depth: float
    memory: dict[float, tuple[Floats, Floats]] = field(default_factory=dict, compare=False, repr=False)

    def points(self, accuracy: float) -> tuple[Floats, Floats]:
        """Return places (n, 2) [m] and shares (levels, n) of loads with the same field to this share of its peak."""
        if accuracy < ALL_CELLS:
            return self.places, self.shares
        if accuracy not in self.memory:
            self.memory[accuracy] = equivalent_points(self.places, self.shares, self.depth, accuracy)
        return self.memory[accuracy]


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
        """Return the mean square distance [m^2] of the load from the body's middle in a frame."""
        level = self.first[frame]
        squares = self.pattern.shares[level : level + 2] @ (self.pattern.places**2).sum(axis=1)
        return float(self.weights[frame, : len(squares)] @ squares)

    def of_frames(self, part: slice) -> "PatternLoads":
        """Return the loads of some of the frames."""
        return replace(self, rows=self.rows[part], first=self.first[part], weights=self.weights[part])

    def count(self, accuracy: float) -> int:
        """Return the number of point loads in a frame."""
        return len(self.pattern.points(accuracy)[0])

    def points(self, accuracy: float = COARSE) -> Floats:
        """Return the point loads (frames, n, 5) whose field is right to this share of its peak, 0 for all cells."""
        places, shares = self.pattern.points(accuracy)
        out = np.empty((len(self.rows), len(places), COLUMNS))
        share = self.weights[:, :1] * shares[self.first] + self.weights[:, 1:] * shares[self.first + 1]
        out[..., PLACE] = self.rows[:, None, PLACE] + places
        out[..., FORCE] = self.rows[:, None, FORCE] * share[..., None]
        return out
