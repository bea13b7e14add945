"""A bonded layer under a periodic traction, wave by wave, and under point loads: the reference for its table."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.core.loads import FORCE, PLACE, F, Q, R, X, Y
from tactile.elastic.halfspace import check_loads, point_load
from tactile.elastic.layer import transfer
from tactile.elastic.layer_loads import REACH, layer_table
from tactile.elastic.medium import Medium


def layer_load(positions: ArrayLike, depth: float, loads: ArrayLike, thickness: float, medium: Medium) -> Floats:
    """Strain or stress, as the medium says, under point loads on a layer bonded to a rigid base.

    The half-space's closed form plus ``layer_term``. Arguments and errors: as these two.
    """
    return point_load(positions, depth, loads, medium) + layer_term(positions, depth, loads, thickness, medium)


def layered_load(positions: ArrayLike, depth: float, loads: ArrayLike, medium: Medium) -> Floats:
    """Strain or stress under point loads on the half-space, or on the layer where the medium has a thickness."""
    return layer_load(positions, depth, loads, medium.thickness, medium)


def layer_term(positions: ArrayLike, depth: float, loads: ArrayLike, thickness: float, medium: Medium) -> Floats:
    """Layer minus half-space under point loads, by the formulas of ``sums.layer_sum``.

    Raises:
        InputError: as ``point_load``, and a depth beyond the thickness.
    """
    at, rows = np.asarray(positions, dtype=np.float64), check_loads(loads)
    if not thickness > 0 or depth > thickness:
        raise InputError(f"taxels {depth} m deep in a layer of {thickness} m, a thickness of at least the depth wanted")
    x, y = at[..., 0, None] - rows[..., X], at[..., 1, None] - rows[..., Y]
    if np.isinf(thickness) or thickness > 1e8 * depth:  # below 1e-15 of the half-space's own field
        return np.zeros((*x.shape[:-1], 3))
    rho = np.hypot(x, y)
    c, s = np.where(rho > 0, x, 1) / np.where(rho > 0, rho, 1), y / np.where(rho > 0, rho, 1)
    unit = 1.0 if medium.quantity == "stress" else 1 / medium.modulus
    table = layer_table(depth / thickness, medium.nu, medium.quantity)
    near, reached = rho < REACH * thickness, np.minimum(rho / thickness / REACH, 1)
    normal, normal_shear, shear_normal, even, odd = np.moveaxis(table(np.sqrt(reached)) * (unit / thickness**2), -1, 0)
    q, r, f = rows[..., Q], rows[..., R], rows[..., F]
    along = q * c + r * s
    x_z = -f * c * shear_normal + q * even - (2 * c * along - q) * odd
    y_z = -f * s * shear_normal + r * even - (2 * s * along - r) * odd
    z_z = f * normal - along * normal_shear
    added = np.stack([np.where(near, part, 0).sum(-1) for part in (x_z, y_z, z_z)], axis=-1)
    if not near.all():
        far = np.where(near[..., None], 0, rows[..., FORCE])
        added -= point_load(
            at, depth, np.concatenate([np.broadcast_to(rows[..., PLACE], (*far.shape[:-1], 2)), far], -1), medium
        )
    return added


def periodic_field(traction: ArrayLike, pitch: float, depth: float, thickness: float, medium: Medium) -> Floats:
    """Strain or stress under a periodic traction map (rows, cols, 3) [Pa], at the points of the map.

    Raises:
        InputError: as ``transfer``, or a map of another shape.
    """
    given = np.asarray(traction, dtype=np.float64)
    if given.ndim != 3 or given.shape[2] != 3:
        raise InputError(f"traction map of shape {given.shape}, (rows, cols, 3) wanted")
    rows, cols = given.shape[:2]
    k_y = 2 * np.pi * np.fft.fftfreq(rows, pitch)[:, None]
    k_x = 2 * np.pi * np.fft.rfftfreq(cols, pitch)[None, :]
    k = np.hypot(k_x, k_y)
    c, s = np.where(k > 0, k_x, 1) / np.where(k > 0, k, 1), k_y / np.where(k > 0, k, 1)
    waves = np.fft.rfft2(given, axes=(0, 1))
    along, across = c * waves[..., 0] + s * waves[..., 1], -s * waves[..., 0] + c * waves[..., 1]
    by = transfer(k, depth, thickness, medium)
    sz = 1j * by.shear_normal * waves[..., 2] + by.shear * along
    tz = by.across * across
    zz = by.normal * waves[..., 2] + 1j * by.normal_shear * along
    felt = np.stack([c * sz - s * tz, s * sz + c * tz, zz], axis=-1)
    return np.fft.irfft2(felt, s=(rows, cols), axes=(0, 1))
