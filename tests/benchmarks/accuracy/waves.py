"""What a bonded layer adds under one point load, by Gauss points over the waves: no table, no spline."""

import numpy as np
from scipy.special import j0, j1, jv

from cnnsim.support import Floats
from tactile.elastic.gauss import gauss
from tactile.elastic.layer import transfer
from tactile.elastic.medium import Medium

FALL = 46.0
"""exp(-46) is 1e-20: beyond it waves do not count."""


def by_waves(at: Floats, depth: float, load: Floats, thickness: float, medium: Medium, count: int) -> Floats:
    """Layer minus half-space at places (n, 2) under one load (x, y, Q, R, F), as in ``elastic.layer_loads``."""
    nodes, weights = gauss(count)
    top = FALL / (2 * thickness - depth)
    k, step = top * (nodes + 1) / 2, top * weights / 2
    layer, half = transfer(k, depth, thickness, medium), transfer(k, depth, np.inf, medium)
    x, y = (at - load[:2]).T
    rho = np.hypot(x, y)
    c, s = np.where(rho > 0, x, 1) / np.where(rho > 0, rho, 1), y / np.where(rho > 0, rho, 1)
    phase = k * rho[:, None]

    def gap(name: str) -> Floats:
        return np.asarray((getattr(layer, name) - getattr(half, name)) * k * step / (2 * np.pi))

    even, odd = (gap("shear") + gap("across")) / 2, (gap("shear") - gap("across")) / 2
    q, r, f = load[2:]
    along = q * c + r * s
    drag, by_even, by_odd = j1(phase) @ gap("shear_normal"), j0(phase) @ even, jv(2, phase) @ odd
    x_z = -f * c * drag + q * by_even - (2 * c * along - q) * by_odd
    y_z = -f * s * drag + r * by_even - (2 * s * along - r) * by_odd
    z_z = f * (j0(phase) @ gap("normal")) - along * (j1(phase) @ gap("normal_shear"))
    return np.stack([x_z, y_z, z_z], axis=-1)
