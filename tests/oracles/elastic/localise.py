"""Located loads by SciPy: least squares from the true loads on, and the Cramer-Rao bound of an unbiased estimate."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from cnnsim.support import Floats

Forward = Callable[[Floats], Floats]
"""Signals (rows, cols, 3) of the loads (k, 5)."""


def nearest(forward: Forward, signals: Floats, loads: Floats, scale: Floats) -> Floats:
    """Return the loads (k, 5) near ``loads`` that explain the signals best; ``scale`` (5,): their units."""
    size = np.abs(signals).max()

    def rest(p: Floats) -> Floats:
        return np.asarray((forward(p.reshape(-1, 5) * scale) - signals).ravel() / size)

    found = least_squares(rest, (loads / scale).ravel(), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    return np.asarray(found.x).reshape(-1, 5) * scale


def bound(
    forward: Forward, load: Floats, noise: float, scale: Floats, told: tuple[int, ...] = (0, 1, 2, 3, 4)
) -> Floats:
    """Return the least standard deviations that unbiased estimates of those parts of one load can have."""
    columns = []
    for k in told:
        step = np.zeros(5)
        step[k] = 1e-6 * scale[k]
        columns.append((forward((load + step)[None]) - forward((load - step)[None])).ravel() / 2e-6)
    slopes = np.array(columns).T
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes))) * noise * scale[list(told)])
