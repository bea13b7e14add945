"""The exact flow of a linear template: from kink to kink, each located, and between them by the matrix exponential.

While no cell enters or leaves its saturation the network is linear, dx/dt = J x + c, and x(t) = exp(J t) x0 + ... is
its Taylor series, whose terms are products of the sparse matrix and a vector. A cell's x(t) is then a polynomial, and
the first time at which one of them meets -1 or +1 is the next kink: there the state is computed, the cell changes its
piece, and a new series begins. Nothing is cut off but the tail of the series, below 1e-16.
"""

import numpy as np

from cnnsim.accuracy.system import LinearSystem
from cnnsim.support import Floats, InputError, Integers

TERMS = 26
"""Of the series. With |J| s <= 2 the first one left out is 2^26 / 26! = 2e-19 of the state."""
_SAMPLES = np.linspace(0, 1, 17)
_POWERS = _SAMPLES[:, None] ** np.arange(TERMS)
_TOUCH = 2e-15
"""A cell that passes its kink by less, and comes back, has not passed it."""


def exact_state(system: LinearSystem, x: Floats, duration: float, most_kinks: int = 10**6) -> Floats:
    """Return x(``duration``) of a state (cells,), to about 1e-13 times the growth of rounding errors.

    Raises:
        InputError: more kinks than ``most_kinks`` (a network that never rests).
    """
    from scipy.optimize import brentq  # slow to import, and only needed for references

    x, piece = x.astype(np.float64), np.sign(x) * (np.abs(x) > 1)
    edge = np.abs(x) == 1
    if edge.any():  # on a kink the piece is that to which the cell goes
        outwards = np.sign(x) * (system.matrix @ x.clip(-1, 1) + system.drive - x) >= 0
        piece[edge & outwards] = np.sign(x[edge & outwards])
    piece[~system.free] = np.sign(x[~system.free]) * (np.abs(x[~system.free]) >= 1)
    window, left, kinks = 2.0 / system.norm, float(duration), 0
    while left > 0:
        s = min(window, left)
        series = _series(system, x, piece)
        gaps, cells, sides = _near(system, series, piece, s)
        met: list[tuple[float, int, float]] = []
        if len(cells):
            values = gaps @ (_POWERS * s ** np.arange(TERMS)).T
            crossed = values < -_TOUCH
            crossed[:, 0] = False  # a cell that has just met its kink stands on it
            first = np.where(crossed.any(axis=1), crossed.argmax(axis=1), len(_SAMPLES))
            first = _grazes(gaps, values, first, s)
            soonest = first.min()
            for i in np.flatnonzero(first == soonest) if soonest < len(_SAMPLES) else ():
                low, high = (_SAMPLES[soonest - 1] * s, _SAMPLES[soonest] * s)
                ahead = gaps[i, ::-1]
                low_value = np.polyval(ahead, low)
                high = _dip(gaps[i], low, high) if np.polyval(ahead, high) >= 0 else high
                root = low if low_value <= 0 else brentq(lambda t, c=ahead: np.polyval(c, t), low, high, xtol=1e-16)
                met.append((float(root), int(cells[i]), float(sides[i])))
        at = min((root for root, _, _ in met), default=s)
        x = at ** np.arange(TERMS) @ series
        for root, cell, side in met:
            if root <= at + 1e-14:
                x[cell] = side
                piece[cell] = 0.0 if piece[cell] else side
                kinks += 1
        if kinks > most_kinks:
            raise InputError(
                f"more than {most_kinks} kinks after {duration - left:g} time constants; a shorter duration wanted"
            )
        left -= at
        left = 0.0 if left < 1e-14 * duration else left
    return x


def _series(system: LinearSystem, x: Floats, piece: Floats) -> Floats:
    """Return the Taylor coefficients (terms, cells) of x about now."""
    linear = piece == 0
    moving = system.free & linear if system.limited else system.free
    series = np.zeros((TERMS, x.size))
    series[0] = x
    y = np.where(linear, x, piece)
    series[1] = np.where(moving, system.matrix @ y + system.drive - x, 0.0)
    for k in range(1, TERMS - 1):
        series[k + 1] = np.where(moving, system.matrix @ (series[k] * linear) - series[k], 0.0) / (k + 1)
    return series


def _near(system: LinearSystem, series: Floats, piece: Floats, s: float) -> tuple[Floats, Integers, Floats]:
    """Return how far cells are from their kinks, as polynomials (n, terms), of those that may meet one within ``s``."""
    reach_of = s ** np.arange(1, TERMS) @ np.abs(series[1:])
    linear = system.free & (piece == 0)
    found: list[tuple[Floats, Integers, Floats]] = []
    for side in (1.0, -1.0):
        cells = np.flatnonzero(linear & (1 - side * series[0] <= reach_of))
        gap = -side * series[:, cells].T
        gap[:, 0] += 1
        found.append((gap, cells, np.full(cells.size, side)))
    if system.limited:  # a stopped cell goes on when its rate turns round
        cells = np.flatnonzero(system.free & (piece != 0))
        rate = np.array([system.matrix @ term for term in series])[:, cells]
        rate[0] += (system.drive - series[0])[cells]
        gap = (rate * piece[cells]).T
    else:
        cells = np.flatnonzero(system.free & (piece != 0) & (piece * series[0] - 1 <= reach_of))
        gap = (series[:, cells] * piece[cells]).T
        gap[:, 0] -= 1
    found.append((gap, cells, piece[cells]))
    gaps, cells, sides = (np.concatenate(part) for part in zip(*found, strict=True))
    return gaps, cells, sides


def _grazes(gaps: Floats, values: Floats, first: Integers, s: float) -> Integers:
    """Return the first samples again, with dips below 0 between two samples found as well."""
    bend = np.abs(gaps[:, 2:] * np.arange(2, TERMS) * np.arange(1, TERMS - 1)) @ s ** np.arange(TERMS - 2)
    depth = bend * (s / (len(_SAMPLES) - 1)) ** 2 / 8
    shallow = np.minimum(values[:, :-1], values[:, 1:]) < depth[:, None]
    for i, j in zip(*np.nonzero(shallow), strict=True):
        if j + 1 < first[i] and values[i, j] > 0 and values[i, j + 1] > 0:
            low, high = _SAMPLES[j] * s, _SAMPLES[j + 1] * s
            if np.polyval(gaps[i, ::-1], _dip(gaps[i], low, high)) < -_TOUCH:
                first[i] = j + 1
    return first


def _dip(gap: Floats, low: float, high: float) -> float:
    """Return where a polynomial is least between two places."""
    from scipy.optimize import minimize_scalar  # as above

    return float(minimize_scalar(lambda t: np.polyval(gap[::-1], t), bounds=(low, high), method="bounded").x)
