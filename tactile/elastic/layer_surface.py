"""Surface displacement of a bonded layer under waves: reduction by the base, and its cosine transforms."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from cnnsim.support import Floats
from tactile.elastic.gauss import panels

WIDEST = 20.0
"""Largest contact radius over thickness in tables."""


def excess(turn: Floats, nu: float) -> Floats:
    """Return 1 - T(k h): the relative reduction of the surface displacement under a normal wave by the layer's base."""
    kappa = 3 - 4 * nu
    square, fall = 1 + kappa**2 + 4 * turn**2, np.exp(-2 * turn)
    top = 2 * kappa * fall**2 + (square + 4 * turn) * fall
    out: Floats = top / (kappa * (1 + fall**2) + square * fall)
    return out


def along_excess(turn: Floats, nu: float) -> Floats:
    """Return the relative reduction as in `excess`, under a tangential wave along its wave vector."""
    kappa = 3 - 4 * nu
    square, fall = 1 + kappa**2 + 4 * turn**2, np.exp(-2 * turn)
    # 1 - (2 kappa sinh 2k + 4 k) / (2 kappa cosh 2k + 4 k^2 + 1 + kappa^2)
    out: Floats = (2 * kappa * fall**2 + (square - 4 * turn) * fall) / (kappa * (1 + fall**2) + square * fall)
    return out


def across_excess(turn: Floats, nu: float = 0.5) -> Floats:
    """Return the reduction under a tangential wave across its wave vector: 1 - tanh(k h) at any Poisson's ratio."""
    fall = np.exp(-2 * turn)
    out: Floats = 2 * fall / (1 + fall)
    return out


@lru_cache(maxsize=32)
def cosine_transform(of: Callable[[Floats, float], Floats], nu: float = 0.5) -> CubicSpline:
    """Return M(x), lengths in thicknesses, of one of the functions above."""
    k, weights = panels(24.0, 121)  # exp(-48) is left out; 16 nodes for 8 turns of the fastest wave
    step = of(k, nu) * weights
    x = np.concatenate([np.linspace(0, 8, 401), np.linspace(8, 2 * WIDEST, 401)[1:]])
    return CubicSpline(x, np.cos(np.outer(x, k)) @ step)


def spread(kernel: CubicSpline, at: Floats, t: Floats, step: Floats) -> Floats:
    """Return the matrix that maps W at nodes t > 0 to (1 / pi) integral of M(at - s) W(s) ds, for an even W."""
    both: Floats = (kernel(np.abs(at[:, None] - t)) + kernel(at[:, None] + t)) * step / np.pi
    return both
