"""Disc: an even pressure on a circle of a given radius, as of a soft pad."""

from cnnsim.support import Floats
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import UNIFORM
from tactile.simulator.contacts.shapes.flat_punch import FlatPunch
from tactile.simulator.contacts.shapes.shape import RoundShape


class DiscShape(RoundShape):
    """A circle of a ``radius``, p = P / (pi a^2). It sinks in like a flat punch."""

    name = "disc"
    pressure = UNIFORM

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the indentation [m] of a flat punch."""
        return FlatPunch(self.radius).indentation(force, medium)

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Return that of a flat punch."""
        return FlatPunch(self.radius).held_factor(force, rise, medium, tip_radius)
