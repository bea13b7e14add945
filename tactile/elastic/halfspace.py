"""Strain and stress under point loads on an elastic half-space, by the formulas of Boussinesq and Cerruti."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, F, Q, R, X, Y
from tactile.elastic.medium import Medium


def point_load_strain(positions: ArrayLike, depth: float, loads: ArrayLike, modulus: float, nu: float = 0.5) -> Floats:
    """Return the strain (u_xz, u_yz, u_zz) under point loads on a half-space of any Poisson's ratio.

    Each load adds, with (x, y, z) the taxel seen from it and r^2 = x^2 + y^2 + z^2,

        (1 + nu) (Q x + R y + F z) / (2 pi E r^5) * (-3 x z, -3 y z, 2 nu r^2 - 3 z^2)

    Arguments: ``positions`` (..., 2) taxel centres [m]; ``depth`` z [m]; ``loads`` (n, 5), rows
    (x, y, Q, R, F) [m, m, N, N, N]; ``modulus`` E [Pa]; ``nu``, 1/2 in the paper. Loads of shape (..., n, 5)
    broadcast against ``positions``. Returns (..., 3).

    Raises:
        InputError: wrong shapes, a depth or modulus that is not positive, a nu outside 0 .. 1/2.

    Source: Boussinesq and Cerruti, as in Johnson, Contact Mechanics, eqs (3.18), (3.75); for nu = 1/2
    Vasarhelyi, Fodor, Roska, eq. (1).
    """
    return point_load(positions, depth, loads, Medium(modulus, nu))


def point_load_stress(positions: ArrayLike, depth: float, loads: ArrayLike) -> Floats:
    """Return the stress (sigma_xz, sigma_yz, sigma_zz) [Pa] under point loads on a half-space of any Poisson's ratio.

    Each load adds, with (x, y, z) the taxel seen from it and r^2 = x^2 + y^2 + z^2,

        3 (Q x + R y + F z) / (2 pi r^5) * (-x z, -y z, -z^2)

    Arguments and shapes: as ``point_load_strain``.

    Raises:
        InputError: wrong shapes, a depth that is not positive.

    Source: Vasarhelyi, Fodor, Roska, eq. (10).
    """
    return point_load(positions, depth, loads, Medium(1.0, quantity="stress"))


def point_load(positions: ArrayLike, depth: float, loads: ArrayLike, medium: Medium) -> Floats:
    """Return the strain or stress (the quantity of the medium) under point loads: reference for faster methods.

    Arguments, shapes and errors: as ``point_load_strain``.
    """
    scale, trace = point_scale(depth, medium)
    at = np.asarray(positions, dtype=np.float64)
    rows = check_loads(loads)
    if at.ndim < 1 or at.shape[-1] != 2:
        raise InputError(f"taxel positions of shape {at.shape}, (..., 2) wanted")
    # lengths in depths, so that no fifth power overflows
    x = (at[..., 0, None] - rows[..., X]) / depth
    y = (at[..., 1, None] - rows[..., Y]) / depth
    nearness = 1 / (1 + x * x + y * y)
    weight = (rows[..., Q] * x + rows[..., R] * y + rows[..., F]) * (nearness * np.sqrt(nearness)) * scale
    # summed over the loads: the body is linear
    components = -3 * weight * nearness * x, -3 * weight * nearness * y, weight * (trace - 3 * nearness)
    return np.stack([part.sum(-1) for part in components], axis=-1)


def point_scale(depth: float, medium: Medium) -> tuple[float, float]:
    """(c / (2 pi z^2), 2 n) with the medium's reading (c, n): the factors of every method.

    Raises:
        InputError: a depth that is not positive, or so small that readings overflow.
    """
    if not 0 < depth < math.inf:
        raise InputError(f"depth {depth} m, a positive length wanted")
    factor, trace = medium.reading
    scale = factor / (2 * math.pi) / depth / depth if depth > 1e-150 else math.inf
    if not math.isfinite(scale):
        raise InputError(f"depth {depth} m: the reading under a load overflows, a larger depth wanted")
    return scale, 2 * trace


def check_loads(loads: ArrayLike) -> Floats:
    """Return loads as an array (..., n, 5) of finite numbers.

    Raises:
        InputError: another shape, or a load that is not finite.
    """
    rows = np.asarray(loads, dtype=np.float64)
    if rows.ndim < 2 or rows.shape[-1] != COLUMNS:
        raise InputError(f"loads of shape {rows.shape}, (n, 5) with rows (x, y, Q, R, F) wanted")
    if not np.isfinite(rows).all():
        where = np.argwhere(~np.isfinite(rows).all(-1))[0].tolist()
        raise InputError(f"load {where} is not finite, rows (x, y, Q, R, F) of finite numbers wanted")
    return rows
