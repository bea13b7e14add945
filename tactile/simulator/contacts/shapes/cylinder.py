"""Cylinder: a rigid cylinder that lies on the cover."""

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.shapes.shape import LineShape, growth

STEPS, SHARE = 60, 1e-3
"""Most steps of Newton's method, of which five are usual, and the share of a force over which the slope is taken: each
step reduces the error by about this factor."""


class Cylinder(LineShape):
    """A cylinder of a ``radius``, ``length`` and ``angle`` of its axis. Source: ``tactile.elastic.lines``."""

    name = "cylinder"
    needs = ("radius", "length")
    curved = True

    def points(self, total: Floats, depth: float, medium: Medium) -> Floats:
        """Return Gauss points along the axis and across the contact."""
        from tactile.elastic.lines import cylinder_half_width, cylinder_loads

        width = cylinder_half_width(total[:, F], self.length, self.radius, medium)
        if np.isfinite(medium.thickness):
            self.indentation(total[:, F].max(initial=0, keepdims=True), medium)
        return cylinder_loads(total, self.length, width, self.angle, depth, medium)

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the mean indentation [m] along the axis: see ``IndenterShape.indentation``."""
        from tactile.elastic.lines import cylinder_half_width, line_indentation

        pressing = np.maximum(force, 0)
        width = cylinder_half_width(pressing, self.length, self.radius, medium)
        deep = line_indentation(pressing, self.length, width, medium)
        if (deep >= medium.thickness).any():
            raise InputError(
                f"a {self.name} {self.length * 1e3:g} mm long sinks {deep.max() * 1e3:.4g} mm under "
                f"{pressing.max():.4g} N into a cover of {medium.thickness * 1e3:g} mm; less than its "
                "thickness wanted"
            )
        return deep

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Solve the indentation for the force by Newton's method in logarithms: it is nearly a power of the force.

        Raises:
            InputError: as ``indentation``; deeper than a cylinder so short sinks in under any force.
        """
        deeper = self.indentation(force, medium) + rise
        touches = (deeper > 0) & (force > 0)
        now, aim = force[touches], deeper[touches]
        for _ in range(STEPS):
            near, aside = self.indentation(now, medium), self.indentation(now * (1 - SHARE), medium)
            with np.errstate(invalid="ignore"):
                power = np.log(near / aside) / -np.log1p(-SHARE)
            if not ((near > 0) & (power > 0) | (aim == near)).all():
                raise InputError(
                    f"a {self.name} {self.length * 1e3:g} mm long held {aim.max() * 1e3:.4g} mm deep; less "
                    "wanted: its contact would be far wider than it is long"
                )
            before, now = now, now * (aim / near) ** (1 / power)
            if (np.abs(now - before) <= 1e-11 * now).all():
                break
        new = np.zeros_like(force)
        new[touches] = now
        return growth(force, new)
