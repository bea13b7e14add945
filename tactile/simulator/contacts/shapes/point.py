"""Point: a force at one place; its mounting holds it by a tip."""

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.shapes.shape import IndenterShape
from tactile.simulator.contacts.shapes.sphere import Sphere


class PointShape(IndenterShape):
    """A point load, without size."""

    name = "point"
    by_tip = True

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Return that of a tip of this radius [m], by Hertz' law, on a layer by ``tip_law``."""
        if np.isinf(medium.thickness):
            return Sphere(tip_radius).held_factor(force, rise, medium, tip_radius)
        from tactile.simulator.contacts import tip_law  # imports SciPy's splines

        return tip_law.held_factor(force, rise, tip_radius, medium)
