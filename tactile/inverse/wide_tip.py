"""Model of a wide tip: Hertz's pressure over a circle, fitted to the signals of all taxels."""

import math

import numpy as np

from cnnsim.support import Floats
from tactile.inverse.single_fit import LoadFit, fitted, made

RADII = (0.15, 0.3, 0.5, 0.7, 0.9, 1.1)
"""Radii [depths] of tips that are tried: smaller ones are points, larger ones no single load."""


def may_be_wide(fit: LoadFit) -> bool:
    """Whether a wide tip explains more than half of the excess, to first order in its area."""
    from tactile.inverse.residual_tests_numba import width  # numba is slow to import

    if len(fit.loads) > 1 or not np.isfinite(fit.covariance).all():
        return False
    along, seen = width(fit.signals[:6], fit.loads[0], fit.covariance, np.empty(5))
    return bool(along > 0 and along * along > 0.5 * seen * (fit.chi - fit.random))


def variance_of_wide(fit: LoadFit) -> float:
    """Return the least residual variance beyond the noise of a tip of any of the radii."""
    signals, load, least = fit.signals, fit.loads, math.inf
    for radius in RADII:
        for _ in range(4):  # each fit is nearer by a factor of 3 to 10
            load = fitted(signals._replace(measured=signals.measured - _width(fit, load, radius)), load).loads
        rest = signals.measured - _width(fit, load, radius) - made(signals, load)
        least = min(least, float((rest * rest).sum()))
    free = max(fit.free - 1, 1)
    random = fit.random * free / max(fit.free, 1)
    return max(least - random, random * math.sqrt(2 / free)) / free


def _width(fit: LoadFit, load: Floats, radius: float) -> Floats:
    """Return the difference of the signals (n, 3) under a wide tip and under a point load (1, 5).

    Hertz's pressure over a circle of radius a has, up to the fourth, the moments of 0.3 of the load in the middle and
    0.7 on a ring of radius sqrt(4 / 7) a.
    """
    parts, angles = np.repeat(load, 7, axis=0), np.arange(6) * (np.pi / 3)
    parts[:6, 0] += radius * math.sqrt(4 / 7) * np.cos(angles)
    parts[:6, 1] += radius * math.sqrt(4 / 7) * np.sin(angles)
    parts[:, 2:] *= np.array([0.7 / 6] * 6 + [-0.7])[:, None]
    return made(fit.signals, parts)
