"""Needle: a rigid hemisphere pressed in to any depth, its contact no wider than itself."""

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.profiles import ROUND_TIP, round_tip_indentation, round_tip_radius
from tactile.simulator.contacts.shapes.shape import RoundShape


class Needle(RoundShape):
    """A tip of a ``radius``. Source: Sneddon (1965), eq. (6.15)."""

    name = "needle"
    has_law = True
    curved = True
    pressure = ROUND_TIP
    on_layer = "sphere"

    def radius_at_force(self, force: Floats, stiff: float) -> Floats:
        """P = E* ((a^2 + R^2) atanh(a / R) - a R), solved for a."""
        return round_tip_radius(force, self.radius, stiff)

    def force_at_indentation(self, indentation: Floats, stiff: float) -> Floats:
        """Solve delta = a atanh(a / R) for a by bisection, then as ``force_at_radius``."""
        wanted = np.maximum(indentation, 0) / self.radius
        low, high = np.zeros_like(wanted), np.maximum(wanted + 1, np.sqrt(wanted))
        for _ in range(60):
            middle = (low + high) / 2
            less = np.tanh(middle) * middle < wanted
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        lam, bend = np.tanh((low + high) / 2), (low + high) / 2
        small = lam < 1e-3
        force: Floats = stiff * self.radius**2 * np.where(small, 4 / 3 * wanted**1.5, (lam**2 + 1) * bend - lam)
        return force

    def force_at_radius(self, radius: Floats, stiff: float) -> Floats:
        """P = E* ((a^2 + R^2) atanh(a / R) - a R)."""
        lam = np.minimum(radius / self.radius, 1 - 1e-15)
        return stiff * self.radius**2 * ((lam**2 + 1) * np.arctanh(lam) - lam)

    def indentation_at_force(self, force: Floats, stiff: float) -> Floats:
        """delta = a atanh(a / R)."""
        return round_tip_indentation(force, self.radius, stiff)
