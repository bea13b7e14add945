"""Threshold levels of every taxel: multiples of its noise, with a floor."""

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
"""Number of taxels up to which 2 contact sigma are used; noise passes 6 sigma once in two days at 100 frames/s."""
CALM = 0.05
"""Floor over the default thresholds once the noise is measured."""


@spelled_class
@dataclass(frozen=True)
class Sigmas:
    """Thresholds as multiples of sigma: ``dead_band``, ``hysteresis`` above it, ``contact`` level (end of contact).

    Normal noise passes 3 sigma once in 10^3 readings, 4 once in 10^4, 6 once in 10^9; noise that is slow or grows
    under a load passes more often, therefore the hysteresis.

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
"""Default multiples."""


@dataclass(frozen=True)
class Levels:
    """Switching levels of the comparators: ``off`` and ``on`` (rows, cols, 3) [unit of the signal], on above off."""

    off: Floats
    on: Floats


def levels(
    shape: tuple[int, int], quantity: Quantity, sigmas: Sigmas, shear: Threshold | None, contact: Threshold | None,
    noise: Noise | None, early: Floats | None = None,
) -> Levels:  # fmt: skip
    """Return the levels: dead_band sigma, and hysteresis sigma more; for contact, contact sigma and as much more.

    Above `FEW` taxels a contact begins at sqrt((2 contact)^2 + 2 ln(taxels / `FEW`)) sigma, so that noise passes it on
    a large array as seldom as 2 contact sigma on `FEW` taxels. ``early`` (rows, cols, 3): sigma of the first frames of
    a large array, used until the noise is known.

    ``shear`` and ``contact`` are the floors of the user. The default floor is the threshold of the quantity (`SHEAR`,
    `CONTACT`) while the noise is unknown, and a twentieth of it afterwards.
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
