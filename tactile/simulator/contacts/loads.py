"""Loads of one finger over some frames: at points, spread over circles, twists, and patterns on cells. They add."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.core.loads import COLUMNS
from tactile.elastic.profiles import Profile

if TYPE_CHECKING:
    from tactile.simulator.contacts.load_pattern import PatternLoads


@dataclass(frozen=True)
class Disc:
    """Loads over circles: ``loads`` (frames, k, 5), ``radii`` (frames, k) [m]; ``owner`` (k,) contacts.

    Of a twist ``loads`` are (frames, k, 6), rows (x, y, 0, 0, 0, M) [m, N m]; the slope of the profile is the traction.

    ``unit`` [m]: the profile's lam is the radius over it, infinite where it has none.
    """

    loads: Floats
    radii: Floats
    profile: Profile
    unit: float
    owner: Integers


@dataclass(frozen=True)
class Loads:
    """All loads on one finger over some frames.

    ``totals`` (frames, contacts, 5): the resultant (x, y, Q, R, F) of each contact; ``points`` (frames, n, 5), with
    their contacts in ``owner`` (n,); ``discs`` and ``twists`` over circles; ``patterns`` over cells.
    """

    totals: Floats
    points: Floats
    owner: Integers
    discs: tuple[Disc, ...] = ()
    twists: tuple[Disc, ...] = ()
    patterns: "tuple[PatternLoads, ...]" = ()

    @property
    def count(self) -> int:
        """The number of loads in a frame; a pattern counts once."""
        return self.points.shape[1] + sum(disc.radii.shape[1] for disc in self.discs) + len(self.patterns)

    @property
    def with_patterns(self) -> Floats:
        """The points, and equivalent points of the patterns: (frames, n, 5)."""
        if not self.patterns:
            return self.points
        return np.concatenate([self.points, *(one.points() for one in self.patterns)], axis=1)

    def of_frames(self, part: slice) -> "Loads":
        """Return the loads of some of the frames."""
        return Loads(
            self.totals[part],
            self.points[part],
            self.owner,
            tuple(replace(one, loads=one.loads[part], radii=one.radii[part]) for one in self.discs),
            tuple(replace(one, loads=one.loads[part], radii=one.radii[part]) for one in self.twists),
            tuple(one.of_frames(part) for one in self.patterns),
        )


def point_loads(rows: Floats) -> Loads:
    """Return the loads of one contact at a point: ``rows`` (frames, 5)."""
    return Loads(rows[:, None], rows[:, None], np.zeros(1, np.int64))


def together(parts: Iterable[Loads], frames: int) -> Loads:
    """Return the loads of several contacts on one finger."""
    given = list(parts)
    if len(given) == 1:
        return given[0]
    none = np.empty((frames, 0, COLUMNS))
    totals, points, owner, discs, twists, patterns = [none], [none], [], [], [], []
    count = 0
    for part in given:
        totals.append(part.totals)
        points.append(part.points)
        owner.append(part.owner + count)
        discs += [replace(disc, owner=disc.owner + count) for disc in part.discs]
        twists += [replace(twist, owner=twist.owner + count) for twist in part.twists]
        patterns += [replace(one, owner=one.owner + count) for one in part.patterns]
        count += part.totals.shape[1]
    return Loads(
        np.concatenate(totals, axis=1),
        np.concatenate(points, axis=1),
        np.concatenate([np.empty(0, np.int64), *owner]),
        tuple(discs),
        tuple(twists),
        tuple(patterns),
    )
