"""The inverse of one strain taxel by root finding on eq. (1), without the closed forms."""

import math

from scipy.optimize import brentq


def solve(u_xz: float, u_yz: float, u_zz: float, depth: float, modulus: float, sign: int) -> tuple[float, float, float]:
    """Return (dx, dy, s / z) of the one load with ``sign`` that gives these strains.

    Along eq. (1) the strain points, in the plane through the load, in the direction (3 r, 2 - r^2) with
    r = rho / z: its angle grows from 0 to pi with r, so there is one r for every direction.
    """
    u_xz, u_yz, u_zz = sign * u_xz, sign * u_yz, sign * u_zz
    shear = math.hypot(u_xz, u_yz)
    wanted = math.atan2(shear, -u_zz)
    r = brentq(lambda r: math.atan2(3 * r, 2 - r * r) - wanted, 0, 1e4, xtol=1e-300, rtol=1e-15)
    # eq. (1) in units of the depth, the load's size left out
    unit = 3 / (4 * math.pi * modulus) * (1 + r * r) ** -2.5 * math.hypot(3 * r, r * r - 2) / depth**2
    rho = r * depth
    return rho * u_xz / shear, rho * u_yz / shear, sign * math.hypot(shear, u_zz) / unit
