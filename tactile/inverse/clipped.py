"""Readings that are cut off at an end of their range that nobody told: the largest ones, where larger ones fit."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.inverse.attempt import Attempt
from tactile.inverse.least_squares.fit import LEAST_FREE, Signals, fitted

CLIPPED = 20.0
"""How many times less of a variance is left without readings that are clipped."""
HINT = 3.0
"""To first order it is at least so many times less."""
NEAR_END = 1e-3
"""Readings that are so near to the largest one may be cut off at the same end."""
ALIKE = 1e-12
"""Readings that are so near to each other are the same number, but for rounding."""


def clipped(one: Attempt) -> Attempt | None:
    """Return the attempt without the largest readings, if they are cut off: larger ones explain all the others."""
    if (found := at_one_end(one)) is not None:
        return found
    from tactile.inverse.least_squares.doubt_numba import without_largest  # numba is slow to import

    signals, loads = one.fit.signals, one.fit.loads
    if one.clipped or one.false or one.fit.free <= LEAST_FREE:
        return None
    if len(loads) == 1:
        parts = signals.seen, signals.felt, signals.scale, loads[0], signals.strain, signals.layer, signals.tie
        chi, beyond, count = without_largest(*parts, NEAR_END)
        if count == 1 and (chi * HINT > one.fit.chi or beyond < 1):
            return None
    found = _without(one, _largest(signals, NEAR_END))
    return found if found is not None and found.left * CLIPPED < one.left else None


def at_one_end(one: Attempt) -> Attempt | None:
    """Return the attempt without the largest readings, if they are alike, no others are, and larger ones fit better.

    No two noisy readings are alike, so little need speak for it beside: less is left a degree of freedom.
    """
    from tactile.inverse.least_squares.doubt_numba import alike_at_end  # numba is slow to import

    signals = one.fit.signals
    if one.clipped or one.false or one.fit.free <= LEAST_FREE:
        return None
    if alike_at_end(signals.felt, signals.scale, ALIKE) < 2:
        return None
    found = _without(one, _largest(signals, ALIKE))
    return found if found is not None and found.fit.chi * one.fit.free < one.fit.chi * found.fit.free else None


def _largest(signals: Signals, near: float) -> Flags:
    """Return which readings (n, 3) are the largest, but for so small a part."""
    raw = np.abs(signals.felt) / np.where(signals.scale > 0, signals.scale, np.inf)
    cut: Flags = raw >= raw.max() * (1 - near)
    return cut


def _without(one: Attempt, cut: Flags) -> Attempt | None:
    """Return the attempt without these readings (n, 3), if larger ones fit."""
    signals = one.fit.signals
    felt, scale = (np.where(cut, 0.0, part) for part in (signals.felt, signals.scale))
    fit = fitted(signals._replace(felt=felt, scale=scale, lost=signals.lost + int(cut.sum())), one.fit.loads)
    larger: Floats = fit.made(signals)[cut] / signals.felt[cut]
    if not (larger > 1).all():
        return None
    return replace(one, fit=fit, clipped=tuple(signals.cells[cut.any(axis=1)].tolist()))
