"""Slide: the force on one finger over time while a material moves under it."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError


@dataclass(frozen=True)
class Slide:
    """One stroke over one material.

    Arguments: ``name``; ``t`` (n,) [s], increasing; ``force`` (n, 3): shear_x, shear_y and normal in one unit, the
    normal positive when pressed; ``material``, empty if unknown; ``block``: group of slides recorded together;
    ``speed`` [m/s], None if unknown.

    Raises:
        InputError: times that do not increase, shapes that do not match, a speed that is not positive.
    """

    name: str
    t: Floats
    force: Floats
    material: str = ""
    block: int = 0
    speed: float | None = None

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.force.shape != (self.t.size, 3):
            raise InputError(
                f"slide {self.name}: times of shape {self.t.shape} and forces of shape {self.force.shape};"
                " (n,) and (n, 3) wanted"
            )
        if not (np.isfinite(self.t).all() and (np.diff(self.t) > 0).all()):
            raise InputError(f"slide {self.name}: times that do not increase; increasing times [s] wanted")
        if self.speed is not None and not (np.isfinite(self.speed) and self.speed > 0):
            raise InputError(f"slide {self.name}: speed {self.speed} m/s; a positive number wanted")

    def __repr__(self) -> str:
        span = self.t[-1] - self.t[0] if self.t.size else 0.0
        return f"Slide({self.name!r}, {self.material or 'unknown'!r}, {self.t.size} samples in {span:.3g} s)"
