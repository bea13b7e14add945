"""Edge: the same force everywhere along a straight line."""

from dataclasses import replace

from cnnsim.support import Floats
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.shapes.cylinder import Cylinder
from tactile.simulator.contacts.shapes.shape import LineShape


class EdgeShape(LineShape):
    """A line of a ``length`` and ``angle``; its indentation is that of a cylinder of its ``radius``."""

    name = "edge"
    by_tip = True

    def points(self, total: Floats, depth: float, medium: Medium) -> Floats:
        """Return Gauss points along the line."""
        from tactile.elastic.lines import edge_loads

        return edge_loads(total, self.length, self.angle, depth)

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the mean indentation [m] along the line."""
        return self._cylinder(self.radius).indentation(force, medium)

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Return that of a cylinder as round as the mounting's tip."""
        return self._cylinder(tip_radius).held_factor(force, rise, medium, tip_radius)

    def _cylinder(self, radius: float) -> Cylinder:
        return replace(Cylinder(self.radius, self.length, self.angle), radius=radius)
