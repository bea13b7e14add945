"""Point loads on an elastic half-space: what taxels at one depth feel of them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.errors import InputError


def point_load_strain(positions: ArrayLike, depth: float, loads: ArrayLike, modulus: float) -> NDArray[np.float64]:
    """Strain (u_xz, u_yz, u_zz) under point loads on an incompressible half-space.

    Each load adds, with (x, y, z) the taxel seen from it and r^2 = x^2 + y^2 + z^2,

        3 (Q x + R y + F z) / (4 pi E r^5) * (-3 x z, -3 y z, x^2 + y^2 - 2 z^2)

    Arguments: ``positions`` (..., 2) taxel centres [m]; ``depth`` z [m]; ``loads`` (n, 5), rows
    (x, y, Q, R, F) [m, m, N, N, N]; ``modulus`` E [Pa]. Loads of shape (..., n, 5) broadcast against
    ``positions``. Returns (..., 3).

    Raises:
        InputError: wrong shapes, a depth or modulus that is not positive.

    Source: Vasarhelyi, Fodor, Roska, eq. (1).
    """
    if not (np.isfinite(modulus) and modulus > 0):
        raise InputError(f"Young's modulus {modulus} Pa, a positive number wanted")
    x, y, weight = _seen_from_loads(positions, depth, loads)
    weight *= 9 / (4 * np.pi * modulus * depth**2)
    # summed over the loads: the body is linear
    return np.stack(
        [-(weight * x).sum(-1), -(weight * y).sum(-1), (weight * ((x * x + y * y - 2) / 3)).sum(-1)], axis=-1
    )


def point_load_stress(positions: ArrayLike, depth: float, loads: ArrayLike) -> NDArray[np.float64]:
    """Stress (sigma_xz, sigma_yz, sigma_zz) [Pa] under point loads on a half-space of any Poisson's ratio.

    Each load adds, with (x, y, z) the taxel seen from it and r^2 = x^2 + y^2 + z^2,

        3 (Q x + R y + F z) / (2 pi r^5) * (-x z, -y z, -z^2)

    Arguments and shapes: as ``point_load_strain``.

    Raises:
        InputError: wrong shapes, a depth that is not positive.

    Source: Vasarhelyi, Fodor, Roska, eq. (10).
    """
    x, y, weight = _seen_from_loads(positions, depth, loads)
    weight *= -3 / (2 * np.pi * depth**2)
    return np.stack([(weight * x).sum(-1), (weight * y).sum(-1), weight.sum(-1)], axis=-1)


def _seen_from_loads(
    positions: ArrayLike, depth: float, loads: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return x / z, y / z and (Q x + R y + F z) z^4 / r^5, the loads along a new last axis."""
    at = np.asarray(positions, dtype=np.float64)
    rows = np.asarray(loads, dtype=np.float64)
    if at.ndim < 1 or at.shape[-1] != 2:
        raise InputError(f"taxel positions of shape {at.shape}, (..., 2) wanted")
    if rows.ndim < 2 or rows.shape[-1] != 5:
        raise InputError(f"loads of shape {rows.shape}, (n, 5) with rows (x, y, Q, R, F) wanted")
    if not (np.isfinite(depth) and depth > 0):
        raise InputError(f"depth {depth} m, a positive length wanted")
    # lengths in units of the depth, so that no fifth power leaves the range of the numbers
    x = (at[..., 0, None] - rows[..., 0]) / depth
    y = (at[..., 1, None] - rows[..., 1]) / depth
    nearness = 1 / (1 + x * x + y * y)
    turning = rows[..., 2] * x + rows[..., 3] * y + rows[..., 4]
    return x, y, turning * nearness**2 * np.sqrt(nearness)
