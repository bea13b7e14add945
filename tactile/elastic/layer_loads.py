"""Share of a bonded layer, layer minus half-space, in the strain and stress under point loads: waves and tables."""

from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import j0, j1

from cnnsim.support import Floats
from tactile.elastic.gauss import panels
from tactile.elastic.layer import transfer
from tactile.elastic.medium import FieldQuantity, Medium

REACH = 30.0
"""Distance in thicknesses beyond which a bonded layer's field is 0: it decays exponentially."""
POINTS = 640
"""Radii in a table, denser near the load; the spline between them is good to 1e-8 of the peak."""
PANEL = 14.0
"""Phase of the fastest Bessel function over one panel of 16 Gauss nodes: good to 1e-10."""


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
