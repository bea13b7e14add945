"""Elastic medium: Young's modulus, Poisson's ratio, thickness, and whether strain or stress is read."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

from cnnsim.support import InputError

FieldQuantity = Literal["strain", "stress"]
"""The quantity that a taxel measures."""
FIELD_QUANTITIES = get_args(FieldQuantity)


@dataclass(frozen=True)
class Medium:
    """A homogeneous, isotropic, linear elastic body, and the quantity read from it.

    Arguments: ``modulus`` Young's modulus E [Pa]; ``nu`` Poisson's ratio, 0 to 1/2; ``quantity``: "strain" reads
    (u_xz, u_yz, u_zz), "stress" reads (sigma_xz, sigma_yz, sigma_zz) [Pa]; ``thickness`` [m] of a layer bonded to a
    rigid base, infinite for the half-space.

    Raises:
        InputError: a modulus or thickness that is not positive, a Poisson's ratio outside 0 .. 1/2, an unknown
            quantity.
    """

    modulus: float
    nu: float = 0.5
    quantity: FieldQuantity = "strain"
    thickness: float = math.inf

    def __post_init__(self) -> None:
        if not 0 < self.modulus < math.inf:
            raise InputError(f"Young's modulus {self.modulus} Pa, a positive number wanted")
        if not 0 <= self.nu <= 0.5:
            raise InputError(f"Poisson's ratio {self.nu}, a number from 0 to 0.5 wanted")
        if not self.thickness > 0:
            raise InputError(f"thickness {self.thickness} m of the cover, a positive length wanted")
        if self.quantity not in FIELD_QUANTITIES:
            raise InputError(f"quantity {self.quantity!r}, one of {', '.join(FIELD_QUANTITIES)} wanted")

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) [Pa]."""
        return self.modulus / (2 * (1 + self.nu))

    @property
    def contact_modulus(self) -> float:
        """E* = E / (1 - nu^2) [Pa], against a rigid indenter."""
        return self.modulus / (1 - self.nu**2)

    @property
    def reading(self) -> tuple[float, float]:
        """(c, n) of the reading c (sigma_xz, sigma_yz, sigma_zz - n P . grad(V) / pi), V the potential of the load.

        (1, 0) for stress; for strain ((1 + nu) / E, nu), as the trace of the stress under
        any surface load is (1 + nu) / pi times P . grad(V).
        """
        return (1.0, 0.0) if self.quantity == "stress" else ((1 + self.nu) / self.modulus, self.nu)
