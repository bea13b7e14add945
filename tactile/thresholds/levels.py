"""Thresholds of every taxel: so many times its own noise, and never below a floor."""

from dataclasses import dataclass

import numpy as np

from cnnsim import InputError
from cnnsim.support import Floats
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number
from tactile.core.frame import NORMAL, Quantity
from tactile.core.noise import Noise
from tactile.thresholds.threshold import CONTACT, SHEAR, Threshold

FEW = 64
"""Taxels up to which 2 contact sigma are kept: at 6 and 100 frames a second noise passes them once in two days."""
CALM = 0.05
"""Part of the thresholds used without any noise that is the floor once noise is measured."""


@spelled_class
@dataclass(frozen=True)
class Sigmas:
    """Thresholds as multiples of sigma: ``dead_band``, ``hysteresis`` above it, ``contact`` level (end of contact).

    Normal noise passes 3 sigma once in 10^3 readings, 4 once in 10^4, 6 once in 10^9; noise that is slow or grows
    under a load passes more often, which is what the hysteresis is for.

    Raises:
        InputError: a negative or infinite number.
    """

    dead_band: float = 4.0
    hysteresis: float = 6.0
    contact: float = 3.0

    def __post_init__(self) -> None:
        for name, value in tuple(vars(self).items()):
            if not is_number(value) or not 0 <= value < float("inf"):
                raise InputError(f"{name} of {value!r} sigma; a number from 0 wanted")
            object.__setattr__(self, name, float(value))


SIGMAS = Sigmas()
"""What is used where a user says nothing."""


@dataclass(frozen=True)
class Levels:
    """Where each taxel's comparators switch: ``off`` and ``on`` (rows, cols, 3) [unit of the signal], on above off."""

    off: Floats
    on: Floats


def levels(
    shape: tuple[int, int], quantity: Quantity, sigmas: Sigmas, shear: Threshold | None, contact: Threshold | None,
    noise: Noise | None, early: Floats | None = None,
) -> Levels:  # fmt: skip
    """Return the levels: dead_band sigma and hysteresis sigma more, for the normal component contact and as much more.

    Of more than `FEW` taxels some one is beyond a level by chance the more often the more there are: a contact of them
    begins at sqrt((2 contact)^2 + 2 ln(taxels / `FEW`)) sigma, which noise passes on all of them together no more often
    than 2 contact on so few. ``early`` (rows, cols, 3): sigma of the first frames of a large array, which holds the
    levels up until the noise is known.

    ``shear`` and ``contact`` are the floors that a user gives. Without them the floor is the quantity's own threshold
    (`SHEAR`, `CONTACT`) while no noise is known, and a twentieth of it once it is: then the noise decides.
    """
    off, on = np.empty((*shape, 3)), np.empty((*shape, 3))
    known = noise is not None and bool(noise.sigma.any())
    sigma = noise.sigma if noise is not None else np.zeros((*shape, 3)) if early is None else early
    begins = np.sqrt((2 * sigmas.contact) ** 2 + 2 * np.log(max(shape[0] * shape[1] / FEW, 1)))
    for part, floor, own, k, more in (
        (slice(0, NORMAL), shear, SHEAR[quantity], sigmas.dead_band, sigmas.hysteresis),
        (slice(NORMAL, NORMAL + 1), contact, CONTACT[quantity], sigmas.contact, begins - sigmas.contact),
    ):
        factor = CALM if known and floor is None else 1.0
        least = own if floor is None else floor
        off[..., part] = np.maximum(k * sigma[..., part], factor * least.dead_band)
        width = np.maximum(more * sigma[..., part], factor * least.hysteresis)
        on[..., part] = off[..., part] + width
    return Levels(off, on)
