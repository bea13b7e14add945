"""Sphere: a rigid ball, taken for a paraboloid, with Hertz' pressure."""

from cnnsim.support import Floats
from tactile.elastic.profiles import HERTZ, hertz_force, hertz_indentation, hertz_radius
from tactile.simulator.contacts.shapes.shape import RoundShape


class Sphere(RoundShape):
    """A ball of a ``radius``. Source: Johnson, Contact Mechanics, eqs (4.22) to (4.24)."""

    name = "sphere"
    has_law = True
    curved = True
    pressure = HERTZ
    on_layer = "paraboloid"

    def radius_at_force(self, force: Floats, stiff: float) -> Floats:
        """a = cbrt(3 P R / (4 E*))."""
        return hertz_radius(force, self.radius, stiff)

    def force_at_indentation(self, indentation: Floats, stiff: float) -> Floats:
        """P = 4/3 E* sqrt(R) delta^1.5."""
        return hertz_force(indentation, self.radius, stiff)

    def force_at_radius(self, radius: Floats, stiff: float) -> Floats:
        """P = 4/3 E* a^3 / R."""
        return 4 / 3 * stiff * radius**3 / self.radius

    def indentation_at_force(self, force: Floats, stiff: float) -> Floats:
        """delta = a^2 / R."""
        return hertz_indentation(force, self.radius, stiff)
