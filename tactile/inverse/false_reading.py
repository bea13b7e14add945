"""One reading that is false, its taxel's others are not: it reads nothing at all, or contradicts all the others."""

from dataclasses import replace

import numpy as np

from tactile.inverse.attempt import ROUNDING, Attempt
from tactile.inverse.clipped import ALIKE
from tactile.inverse.least_squares.fit import STEPS, fitted


def dead(one: Attempt) -> Attempt | None:
    """Return the attempt without the only reading that is nothing at all, where noise is in all the others.

    Noise is never exactly nothing, so nothing else need speak for it; a load without noise may make nothing somewhere.
    """
    from tactile.inverse.least_squares.doubt_numba import reads_nothing  # numba is slow to import

    fit, signals = one.fit, one.fit.signals
    k = reads_nothing(signals.felt, signals.scale, ALIKE)
    if k < 0 or fit.free < 1 or fit.chi <= ROUNDING * fit.whole:
        return None
    felt, scale, cell = signals.felt.copy(), signals.scale.copy(), int(signals.cells[k // 3])
    felt[k // 3, k % 3] = scale[k // 3, k % 3] = 0.0
    less = signals._replace(felt=felt, scale=scale, lost=signals.lost + 1)
    starts = fit.loads, fitted(signals.without(k // 3), fit.loads).loads
    best = min((fitted(less, start) for start in starts), key=lambda found: found.chi)
    return replace(one, fit=best, ambiguous=False, false=(cell,))


def without_a_reading(one: Attempt) -> Attempt | None:
    """Return the attempt without one reading of the strongest taxels if all others say that it is false.

    It is ambiguous where another one may be false instead, and the load then lies elsewhere.
    """
    from tactile.inverse.least_squares import false_reading_numba  # as above

    fit, signals = one.fit, one.fit.signals
    if len(fit.loads) > 1 or one.clipped or one.false:
        return None
    _, most, taken, first = fit.unexplained
    noise = signals.noise or 0.0
    if not false_reading_numba.may_be_false(fit.chi, fit.excess, fit.free, noise, fit.misfit, most, taken):
        return None
    loads, parts = np.empty((2, 5)), (signals.seen, signals.felt, signals.scale)
    body = signals.strain, signals.layer, signals.tie
    k, left, second = false_reading_numba.false_reading(*parts, fit.loads[0], *body, fit.chi, STEPS, first, loads)
    said = false_reading_numba.verdict(fit.chi, left, second, fit.free, noise, loads)
    if said == false_reading_numba.NONE:
        return None
    i, axis = divmod(int(k), 3)
    felt, scale = signals.felt.copy(), signals.scale.copy()
    felt[i, axis] = scale[i, axis] = 0.0
    found = fitted(signals._replace(felt=felt, scale=scale, lost=signals.lost + 1), loads[:1])
    cut = found.made(signals)[i, axis] / signals.felt[i, axis] > 1 if signals.felt[i, axis] else False
    raw = np.abs(signals.felt / np.where(signals.scale > 0, signals.scale, np.inf))
    cell, ambiguous = (int(signals.cells[i]),), said == false_reading_numba.ONE_OF_TWO
    if cut and raw[i, axis] >= raw.max():
        return replace(one, fit=found, ambiguous=ambiguous, clipped=cell)
    return replace(one, fit=found, ambiguous=ambiguous, false=cell)
