"""Gains: linear coefficients from the readings of a taxel to strain."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number


@spelled_class
@dataclass(frozen=True)
class Gains:
    """The linear coefficients of a taxel: u = (shear, shear, normal) * (T_x, T_y, S_n).

    Arguments: ``shear`` alpha_s and ``normal`` alpha_n [unit of the strain per unit of the reading].

    Raises:
        InputError: a coefficient that is zero or not finite.

    Source: Vasarhelyi, Fodor, Roska, eq. (15).
    """

    shear: float
    normal: float

    def __post_init__(self) -> None:
        for name, value in (("shear", self.shear), ("normal", self.normal)):
            if not is_number(value) or not np.isfinite(value) or value == 0:
                raise InputError(f"{name} gain {value}, a finite number other than 0 wanted")

    @property
    def beta_ns(self) -> float:
        """Normal-to-shear sensitivity alpha_s / alpha_n, so that A = beta_ns A_m: eq. (16)."""
        return self.shear / self.normal

    def __call__(self, values: Floats) -> Floats:
        """Return strains (..., 3) of the readings (..., 3)."""
        strain: Floats = values * self._each
        return strain

    @cached_property
    def _each(self) -> Floats:
        return np.array([self.shear, self.shear, self.normal])

    def spread(self, sigma: Floats) -> Floats:
        """Return the standard deviations of the strains for those of the readings (..., 3)."""
        return np.abs(self(sigma))

    def readings(self, limit: Floats) -> Floats:
        """Return the absolute readings (3,) that correspond to a strain ``limit``."""
        return np.asarray(limit / np.abs(self(np.ones(3))))
