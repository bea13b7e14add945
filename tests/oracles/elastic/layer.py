"""A bonded layer under a periodic traction, wave by wave, and under point loads: the reference for its table."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.special import j0, j1

from cnnsim.support import Floats, InputError
from tactile.core.loads import FORCE, PLACE, F, Q, R, X, Y
from tactile.elastic.gauss import panels
from tactile.elastic.halfspace import check_loads, point_load
from tactile.elastic.layer import transfer
from tactile.elastic.layer_field import FARTHEST as REACH
from tactile.elastic.medium import FieldQuantity, Medium

PANEL = 14.0
"""Phase of the fastest Bessel function over one panel of 16 Gauss nodes: good to 1e-10."""
POINTS = 640
"""Radii in a table, denser near the load; the spline between them is good to 1e-8 of the peak."""


def layer_load(positions: ArrayLike, depth: float, loads: ArrayLike, thickness: float, medium: Medium) -> Floats:
    """Strain or stress, as the medium says, under point loads on a layer bonded to a rigid base.

    The half-space's closed form plus ``layer_term``. Arguments and errors: as these two.
    """
    return point_load(positions, depth, loads, medium) + layer_term(positions, depth, loads, thickness, medium)


def layered_load(positions: ArrayLike, depth: float, loads: ArrayLike, medium: Medium) -> Floats:
    """Strain or stress under point loads on the half-space, or on the layer where the medium has a thickness."""
    return layer_load(positions, depth, loads, medium.thickness, medium)


def layer_term(positions: ArrayLike, depth: float, loads: ArrayLike, thickness: float, medium: Medium) -> Floats:
    """Layer minus half-space under point loads.

    With N(k) the difference of the transfer functions, a load P = (Q, R, F) at distance rho = |(x, y)| adds

        zz: F I0[normal] - (Q x + R y) / rho I1[normal_shear]
        xz: -F x / rho I1[shear_normal] + Q I0[(shear + across) / 2]
            - ((2 x^2 / rho^2 - 1) Q + 2 x y / rho^2 R) I2[(shear - across) / 2]

    and yz alike, where Im[N] = integral of k N(k) Jm(k rho) dk / (2 pi).

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


def waves_of(depth: float, medium: Medium) -> tuple[Floats, ...]:
    """Return wavenumbers k and, at them, k / 2 pi times layer minus half-space times the quadrature weights.

    normal, normal_shear, shear_normal, shear and across of `Transfer`, for thickness 1; ``depth`` over the thickness.
    """
    top = 46 / (2 - depth)  # exp(-46) is 1e-20
    k, weight = panels(top, int(np.ceil(top * REACH / PANEL)))
    layer, half = transfer(k, depth, 1.0, medium), transfer(k, depth, np.inf, medium)
    step = k * weight / (2 * np.pi)
    names = ("normal", "normal_shear", "shear_normal", "shear", "across")
    return k, *((getattr(layer, name) - getattr(half, name)) * step for name in names)


@lru_cache(maxsize=64)
def layer_table(depth: float, nu: float, quantity: FieldQuantity) -> CubicSpline:
    """Return the five integrals over sqrt(rho / REACH), for thickness 1 and modulus 1."""
    k, normal, normal_shear, shear_normal, shear, across = waves_of(depth, Medium(1.0, nu, quantity))
    root = np.linspace(0, 1, POINTS)
    phase = k * (REACH * root**2)[:, None]
    zeroth, first = j0(phase), j1(phase)
    second = np.where(phase > 1e-3, 2 * first / np.maximum(phase, 1e-3) - zeroth, phase**2 / 8)
    even, odd = (shear + across) / 2, (shear - across) / 2
    columns = zeroth @ normal, first @ normal_shear, first @ shear_normal, zeroth @ even, second @ odd
    return CubicSpline(root, np.stack(columns, axis=-1))


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
