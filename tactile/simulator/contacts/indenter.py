"""Indenters: the contact radius under a force, the pressure profile and the force law of each shape."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import (
    FLAT_PUNCH,
    HERTZ,
    ROUND_TIP,
    UNIFORM,
    Profile,
    hertz_force,
    hertz_radius,
    punch_force,
    round_tip_radius,
)

ShapeName = Literal["point", "disc", "flat_punch", "sphere", "needle", "edge", "cylinder"]
ROUND: dict[str, Profile] = {"disc": UNIFORM, "flat_punch": FLAT_PUNCH, "sphere": HERTZ, "needle": ROUND_TIP}
"""Shapes whose contact is a circle, and the pressure on it."""


@dataclass(frozen=True)
class Indenter:
    """A rigid body that presses.

    Arguments: ``radius`` [m] of a disc, flat punch, sphere, needle tip or cylinder; ``length`` [m] and ``angle``
    [rad, from x towards y] of an edge or cylinder.

    Raises:
        InputError: an unknown shape, a length or radius that it needs and that is not positive.
    """

    shape: ShapeName = "point"
    radius: float = 0.0
    length: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        if self.shape not in get_args(ShapeName):
            raise InputError(f"shape {self.shape!r}, one of {', '.join(get_args(ShapeName))} wanted")
        if self.shape in (*ROUND, "cylinder") and not self.radius > 0:
            raise InputError(f"a {self.shape} of radius {self.radius} m, a positive length wanted")
        if self.shape in ("edge", "cylinder") and not self.length > 0:
            raise InputError(f"a {self.shape} of length {self.length} m, a positive length wanted")

    def contact_radius(self, force: Floats, medium: Medium) -> Floats:
        """Radius a [m] of a round contact under normal forces [N]."""
        if self.shape == "sphere":
            return hertz_radius(force, self.radius, medium.contact_modulus)
        if self.shape == "needle":
            return round_tip_radius(force, self.radius, medium.contact_modulus)
        return np.full(np.shape(force), self.radius)

    def force_at(self, indentation: Floats, medium: Medium) -> Floats:
        """Normal force [N] at an indentation [m].

        Raises:
            InputError: a shape for which the half-space gives no such law (a point, an edge, a uniform disc).
        """
        if self.shape == "sphere":
            return hertz_force(indentation, self.radius, medium.contact_modulus)
        if self.shape == "flat_punch":
            return punch_force(indentation, self.radius, medium.contact_modulus)
        if self.shape == "needle":
            # delta = a atanh(a / R), solved for lam = a / R by bisection, then Sneddon's force
            wanted = np.maximum(indentation, 0) / self.radius
            low, high = np.zeros_like(wanted), np.maximum(wanted + 1, np.sqrt(wanted))
            for _ in range(60):
                middle = (low + high) / 2
                less = np.tanh(middle) * middle < wanted
                low, high = np.where(less, middle, low), np.where(less, high, middle)
            lam, bend = np.tanh((low + high) / 2), (low + high) / 2
            small = lam < 1e-3
            scaled = np.where(small, 4 / 3 * wanted**1.5, (lam**2 + 1) * bend - lam)
            force: Floats = medium.contact_modulus * self.radius**2 * scaled
            return force
        raise InputError(f"an indentation given for a {self.shape}, a sphere, needle or flat_punch wanted")
