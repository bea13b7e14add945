"""A bonded layer under a periodic traction, wave by wave, and under point loads: the reference for its table."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.elastic.halfspace import point_load
from tactile.elastic.layer import transfer
from tactile.elastic.layer_loads import layer_term
from tactile.elastic.medium import Medium


def layer_load(positions: ArrayLike, depth: float, loads: ArrayLike, thickness: float, medium: Medium) -> Floats:
    """Strain or stress, as the medium says, under point loads on a layer bonded to a rigid base.

    The half-space's closed form plus ``layer_term``. Arguments and errors: as these two.
    """
    return point_load(positions, depth, loads, medium) + layer_term(positions, depth, loads, thickness, medium)


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
