"""Flat punch: a rigid flat end, whose contact is as wide as itself under any force."""

from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import FLAT_PUNCH, Profile, punch_force
from tactile.simulator.contacts.shapes.shape import RoundShape

if TYPE_CHECKING:
    from tactile.elastic.adhesion import AdhesionLaw
    from tactile.simulator.contacts.friction import Carry


class FlatPunch(RoundShape):
    """A circular end of a ``radius``. Source: Johnson, Contact Mechanics, eq. (3.36)."""

    name = "flat_punch"
    has_law = True
    pressure = FLAT_PUNCH
    on_layer = "flat"

    def contact_radius(self, force: Floats, medium: Medium) -> Floats:
        """Return its own radius [m]."""
        return np.full(np.shape(force), self.radius)

    def force_at_indentation(self, indentation: Floats, stiff: float) -> Floats:
        """P = 2 a E* delta."""
        return punch_force(indentation, self.radius, stiff)

    def force_at_radius(self, radius: Floats, stiff: float) -> Floats:
        """Return the force [N] of a punch of that radius at 1 m of indentation."""
        return 2 * stiff * radius

    def indentation_at_force(self, force: Floats, stiff: float) -> Floats:
        """delta = P / (2 a E*)."""
        return force / (2 * self.radius * stiff)

    def stuck_circles(self, force: Floats, stuck: Floats, medium: Medium) -> tuple[Floats, Floats, Profile] | None:
        """Return None: a pull is spread like the pressure."""
        return None

    def carrying(self, medium: Medium) -> "Carry | None":
        """Return None: rings keep their force."""
        return None

    def adhesion(self, medium: Medium, work: float, most: float, by_depth: bool) -> "AdhesionLaw":
        """Return the law of a contact that keeps its width until it snaps off."""
        from tactile.elastic.adhesion import flat_adhesion

        return flat_adhesion(self.radius, self, medium, work, most)
