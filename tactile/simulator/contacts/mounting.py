"""Mounting of contacts over the cover: displacement, rise of the surface, tips, adhesion and curvature of the cover."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, FORCE, PLACE, F
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import ROUND_TIP, round_tip_radius
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.loads import Disc, Loads, point_loads

Move = Callable[[Floats], tuple[Floats, Floats]]
"""From places (frames, 2) [m] to the displacement (frames, 2) [m] and the rise of the cover (frames,) [m]."""


@dataclass(frozen=True)
class Rig:
    """How contacts are held: their ``moves`` in turn, each with the tip radius [m] of contacts at a point.

    ``tip`` [m]: radius of the tip that spreads loads at points, 0 for none; ``work`` of adhesion [J/m^2], 0 for none;
    ``curvature`` [1/m] of the cover's surface.
    """

    moves: tuple[tuple[Move, float], ...] = ()
    tip: float = 0.0
    work: float = 0.0
    curvature: float = 0.0

    def touching(self, body: Indenter) -> Indenter:
        """Return the body that touches a plane as this one touches the curved cover: 1 / R grows by its curvature."""
        if self.curvature == 0 or not body.body.curved:
            return body
        return replace(body, radius=1 / (1 / body.radius + self.curvature))

    def with_move(self, move: Move, needle: float) -> "Rig":
        """Return the mounting with one more move."""
        return replace(self, moves=(*self.moves, (move, needle)))

    def moved(self, rows: Floats, body: Indenter, medium: Medium) -> Floats:
        """Return loads (frames, 5 or more) of a contact at its displaced places, with the forces of its own law."""
        if not self.moves:
            return rows
        rows, rises = self.displaced(rows)
        if not body.body.by_tip:  # its law is the same for all of them
            rises = [(sum_of(rises), 0.0)]
        for rise, needle in rises:
            if rise.any():
                rows[:, FORCE] *= body.held_factor(rows[:, F], rise, medium, needle)[:, None]
        return rows

    def displaced(self, rows: Floats) -> tuple[Floats, list[tuple[Floats, float]]]:
        """Return a copy of loads (frames, 5 or more) at their displaced places, and the rises (frames,) [m] there.

        Successive rises with the same tip radius are summed: a contact that one of them lifts off may touch again.
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
    """Return the total rise of the cover [m] over all movements."""
    return np.asarray(sum(rise for rise, _ in rises))


STILL = Rig()
"""Nothing moves, and points are points."""
POINT = Indenter()


def at_a_point(rows: Floats, medium: Medium, rig: Rig) -> Loads:
    """Return the loads of a contact at a point, rows (frames, 5): a point load, or a circle under the rig's tip."""
    held = rig.moved(rows, POINT, medium)
    if rig.tip == 0:
        return point_loads(held)
    force, profile, unit = held[:, None, F], ROUND_TIP, rig.tip
    if np.isfinite(medium.thickness):
        from tactile.simulator.contacts.tip_law import circle  # imports SciPy's splines

        radii, profile, unit = circle(force, rig.tip, medium)
    else:
        radii = round_tip_radius(force, rig.tip, medium.contact_modulus)
    owner = np.zeros(1, np.int64)
    spread = Disc(held[:, None], radii, profile, unit, owner)
    return Loads(held[:, None], np.empty((len(held), 0, COLUMNS)), owner[:0], (spread,))
