"""A tip that is wide for its depth, as the other reason why the taxels under it fit no point load.

Hertz's pressure over a circle of radius a has the moments of 0.3 of the load in the middle and 0.7 on a ring of radius
sqrt(4/7) a, up to the fourth.
"""

import math

import numpy as np

from cnnsim.support import Floats
from tactile.inverse.attempt import Attempt
from tactile.inverse.least_squares.fit import Signals, fitted, made

RADII = np.array([0.15, 0.3, 0.5, 0.7, 0.9, 1.1])
"""Radii [depths] that are tried: smaller ones are points, larger ones no single load."""
TURNS = 4
"""Fits of a load to what the signals of its width leave: each is nearer by a factor of 3 to 10."""
RING = math.sqrt(4 / 7)
PART = 0.5
"""A tip that explains so small a part to first order explains no more."""


def may_be_a_tip(one: Attempt) -> bool:
    """Whether a tip that is wide explains much of what is left beyond the noise, to first order in its area."""
    from tactile.inverse.least_squares.reliability_numba import normal  # numba is slow to import
    from tactile.inverse.least_squares.width_numba import width

    signals, work = one.fit.signals, np.empty((12, 5))
    parts = signals.seen, signals.felt, signals.scale, one.fit.loads[0], signals.strain, signals.layer, signals.tie
    factor = work[:5]
    if len(one.fit.loads) > 1 or not normal(*parts, work[5:10], work[10], factor):
        return False
    along, seen = width(*parts, factor, work[11])
    return along > 0 and along * along > PART * seen * (one.fit.chi - one.fit.random)


def left_by_a_tip(one: Attempt) -> float:
    """Return what [N^2] a tip of any of the radii leaves at least beyond the noise, per degree of freedom."""
    signals, fit, least = one.fit.signals, one.fit, math.inf
    load = fit.loads[:1]
    for radius in RADII:
        for _ in range(TURNS):
            load = fitted(signals._replace(felt=signals.felt - _width(signals, load, radius)), load).loads
        rest = signals.felt - _width(signals, load, radius) - made(signals, load)
        least = min(least, float((rest * rest).sum()))
    free = max(fit.free - 1, 1)
    random = fit.random * free / max(fit.free, 1)
    return max(least - random, random * math.sqrt(2 / free)) / free * one.top**2


def _width(signals: Signals, load: Floats, radius: float) -> Floats:
    """Return what the width of a tip adds to the signals (n, 3) of a point load."""
    angles = np.arange(6) * (np.pi / 3)
    around = np.repeat(load, 6, axis=0)
    around[:, 0] += radius * RING * np.cos(angles)
    around[:, 1] += radius * RING * np.sin(angles)
    around[:, 2:] *= 0.7 / 6
    middle = load.copy()
    middle[:, 2:] *= -0.7
    return made(signals, np.concatenate([around, middle]))
