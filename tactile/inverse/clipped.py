"""Readings that are cut off at an end of their range that nobody told: the largest ones, where larger ones fit."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Flags
from tactile.inverse.attempt import ROUNDING, Attempt
from tactile.inverse.least_squares.fit import LEAST_FREE, Signals, fitted

CLIPPED = 20.0
"""How many times less of a variance is left without readings that are clipped."""
HINT = 3.0
"""To first order it is at least so many times less."""
TOLD = 5.0
"""Where the noise is known and nothing else is left without them, they are so many deviations too small."""
NEAR_END = 1e-3
"""Readings that are so near to the largest one may be cut off at the same end."""
ALIKE = 1e-12
"""Readings that are so near to each other are the same number, but for rounding."""


def clipped(one: Attempt) -> Attempt | None:
    """Return the attempt without the largest readings, if they are cut off: larger ones explain all the others."""
    if (found := at_one_end(one)) is not None:
        return found
    from tactile.inverse.least_squares.doubt_numba import may_be_cut, without_largest  # numba is slow to import

    fit, signals, loads = one.fit, one.fit.signals, one.fit.loads
    if one.clipped or one.false or fit.free <= LEAST_FREE:
        return None
    noise = signals.noise or 0.0
    if len(loads) == 1:
        parts = signals.seen, signals.felt, signals.scale, loads[0], signals.strain, signals.layer, signals.tie
        if not may_be_cut(fit.chi, noise, *without_largest(*parts, NEAR_END), HINT, TOLD):
            return None
    cut = _largest(signals, NEAR_END)
    found = _without(one, cut)
    if not (found.fit.made(signals)[cut] / signals.felt[cut] > 1).all():
        return None
    told = not found.fit.excess > 0 and fit.chi - found.fit.chi > (TOLD * noise) ** 2 > 0
    return found if told or found.left * CLIPPED < one.left else None


def at_one_end(one: Attempt) -> Attempt | None:
    """Return the attempt without the largest readings, if they are alike and no others are.

    No two noisy readings are alike, so nothing else need speak for it. Where they are so many that too few others are
    left, the load is ambiguous.
    """
    from tactile.inverse.least_squares.doubt_numba import alike_at_end  # numba is slow to import

    fit, signals = one.fit, one.fit.signals
    if one.clipped or one.false or fit.free < 1 or fit.chi <= ROUNDING * fit.whole:
        return None
    count = alike_at_end(signals.felt, signals.scale, ALIKE)
    return _without(one, _largest(signals, ALIKE)) if count > 1 else None


def _largest(signals: Signals, near: float) -> Flags:
    """Return which readings (n, 3) are the largest, but for so small a part."""
    raw = np.abs(signals.felt) / np.where(signals.scale > 0, signals.scale, np.inf)
    cut: Flags = raw >= raw.max() * (1 - near)
    return cut


def _without(one: Attempt, cut: Flags) -> Attempt:
    """Return the attempt without these readings (n, 3); as it is, but ambiguous, where too few others are left."""
    signals = one.fit.signals
    cells = tuple(signals.cells[cut.any(axis=1)].tolist())
    if one.fit.free - int(cut.sum()) < 0:
        return replace(one, ambiguous=True, clipped=cells)
    felt, scale = (np.where(cut, 0.0, part) for part in (signals.felt, signals.scale))
    fit = fitted(signals._replace(felt=felt, scale=scale, lost=signals.lost + int(cut.sum())), one.fit.loads)
    return replace(one, fit=fit, clipped=cells)
