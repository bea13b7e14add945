"""How contacts are held over the cover: by what a rig displaces and raises them, and what they do at its surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, FORCE, PLACE, F
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import ROUND_TIP, round_tip_radius
from tactile.simulator.altered import altered
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.loads import Disc, Loads, point_loads

Move = Callable[[Floats], tuple[Floats, Floats]]
"""From places (frames, 2) [m] to the displacement (frames, 2) [m] and by what the cover rises (frames,) [m]."""
Rises = Sequence[tuple[float, float]]
"""By how much [m] the surface rises, one after the other, each with the tip's radius [m] of contacts at a point."""
CURVED = ("sphere", "needle", "cylinder")
"""Shapes whose radius at the contact a curved cover makes smaller."""
BY_TIP = ("point", "edge")
"""Shapes that are held by the tip of a move, for they have no radius of their own."""


@dataclass(frozen=True)
class Rig:
    """What holds the contacts: ``moves`` of theirs in turn, each with the tip radius [m] of contacts at a point.

    ``tip`` [m]: the tip under which loads at points are spread, 0 for points; ``work`` [J/m^2] of adhesion, 0 where
    nothing sticks; ``curvature`` [1/m] of the cover's surface.
    """

    moves: tuple[tuple[Move, float], ...] = ()
    tip: float = 0.0
    work: float = 0.0
    curvature: float = 0.0

    def touching(self, body: Indenter) -> Indenter:
        """The body that touches a plane as this one touches the curved cover: 1 / R grows by its curvature."""
        if self.curvature == 0 or body.shape not in CURVED:
            return body
        return replace(body, radius=1 / (1 / body.radius + self.curvature))

    def with_move(self, move: Move, needle: float) -> "Rig":
        """The same with one more move."""
        return altered(self, moves=(*self.moves, (move, needle)))

    def moved(self, rows: Floats, body: Indenter, medium: Medium) -> Floats:
        """Loads (frames, 5 or more) of one contact, displaced and pressed as its own law has it."""
        if not self.moves:
            return rows
        rows, rises = self.displaced(rows)
        if body.shape not in BY_TIP:  # its law is the same for all of them
            rises = [(sum_of(rises), 0.0)]
        for rise, needle in rises:
            if rise.any():
                rows[:, FORCE] *= body.held_factor(rows[:, F], rise, medium, needle)[:, None]
        return rows

    def displaced(self, rows: Floats) -> tuple[Floats, list[tuple[Floats, float]]]:
        """A copy of loads (frames, 5 or more) at their displaced places, and by what the cover rises under them [m].

        Each (frames,) with a tip radius: that of moves with the same tip is one, for what one of them lifts off another
        may press on again.
        """
        rows, rises = rows.copy(), list[tuple[Floats, float]]()
        for move, needle in self.moves:
            shift, rise = move(rows[:, PLACE])
            rows[:, PLACE] += shift
            if rises and rises[-1][1] == needle:
                rise = rises.pop()[0] + rise
            rises.append((rise, needle))
        return rows, rises


def sum_of(rises: Sequence[tuple[Floats, float]]) -> Floats:
    """By what all of them raise the cover [m], whatever the tips."""
    return np.asarray(sum(rise for rise, _ in rises))


STILL = Rig()
"""Nothing moves, and points are points."""
POINT = Indenter()


def at_a_point(rows: Floats, medium: Medium, rig: Rig) -> Loads:
    """What a contact at one point, rows (frames, 5), puts on the cover: a point load, or one under the rig's tip."""
    held = rig.moved(rows, POINT, medium)
    if rig.tip == 0:
        return point_loads(held)
    force, profile, unit = held[:, None, F], ROUND_TIP, rig.tip
    if np.isfinite(medium.thickness):
        from tactile.simulator.contacts.tip import circle  # only where called for

        radii, profile, unit = circle(force, rig.tip, medium)
    else:
        radii = round_tip_radius(force, rig.tip, medium.contact_modulus)
    owner = np.zeros(1, np.int64)
    spread = Disc(held[:, None], radii, profile, unit, owner)
    return Loads(held[:, None], np.empty((len(held), 0, COLUMNS)), owner[:0], (spread,))
