"""Smooth curves through a scan over one taxel, with their covariance: shear along and across the scan, and normal.

With the load at X along the scan and Y across it, in depths, t = X^2 + Y^2, w = t / (1 + t), and p, q
polynomials in w whose number of terms minimises Schwarz's criterion (BIC),

    S_n = p(w) / (1 + t)^(3/2),   (T along, T across) = 3 (X, Y) q(w) / (1 + t)^(5/2)

which is eq. (1) with p = 3 w - 2 and eq. (10) with p = w - 1, q constant. Shear points to the load on any skin, so Y
is correct also for skins other than a half-space.
"""

from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np
from numpy.polynomial import polynomial
from scipy.optimize import least_squares
from scipy.signal import fftconvolve

from cnnsim.support import Flags, Floats

TERMS = 8
"""Largest number of terms of p and of q."""
WIDTHS = 24
"""Number of depths tried as starting values."""
CLOSE = {"xtol": 1e-13, "ftol": 1e-13, "gtol": 1e-13}
EXACT = 1e-20
"""Part of the energy of a scan below which residuals are rounding errors."""
LEAST_VARIANCE = 0.01
"""Least assumed variance of a signal over the largest one, since a signal of zero has no residuals."""
MIDDLE, DEPTH, ANGLE, ASIDE, OFFSETS, CURVES = 0, 1, 2, 3, slice(4, 6), 6
"""Indices of the parameters: place and depth in samples, direction of the scan, Y, offsets of the shear, p and q."""
REWEIGHTED = 2
"""Number of fits; each weights the signals by the residuals of the previous one."""
STEP = 1e-5
"""Relative step of numerical derivatives."""


class ScanFit(NamedTuple):
    """``parameters`` of the curves and their ``covariance``, zero for fixed parameters."""

    parameters: Floats
    covariance: Floats

    @property
    def sided(self) -> Self:
        """The same curves with q > 0 in the middle, with the direction of the scan reversed if necessary."""
        if _halves(self.parameters)[1][0] >= 0:
            return self
        sign = np.ones(self.parameters.size)
        sign[CURVES + (sign.size - CURVES + 1) // 2 :] = -1
        turned = self.parameters * sign
        turned[ANGLE] += np.pi
        return self._replace(parameters=turned, covariance=self.covariance * np.outer(sign, sign))

    def spread(self, function: Callable[[Floats], Floats]) -> Floats:
        """Return the standard deviations of a function of the parameters, to first order."""
        free = np.diag(self.covariance) > 0
        slope = _derivatives(function, self.parameters, free)
        return np.asarray(np.sqrt(np.einsum("ik,ij,jk->k", slope, self.covariance[np.ix_(free, free)], slope)))


def curves(parameters: Floats, along: Floats) -> Floats:
    """Return T along, T across and S_n (3, n) of a load at X = ``along`` [depths], without offsets."""
    normal, shear = _halves(parameters)
    aside = parameters[ASIDE]
    t = along * along + aside * aside
    w = t / (1 + t)
    pull = 3 * polynomial.polyval(w, shear) * (1 + t) ** -2.5
    return np.array([along * pull, aside * pull, polynomial.polyval(w, normal) * (1 + t) ** -1.5])


def fit_scan(places: Floats, scan: Floats, angle: float | None) -> ScanFit:
    """Return the fit to T_x, T_y and S_n (3, n) at places in samples.

    ``angle``: starting value of the scan's direction; None if the scan is along x over the taxel and T_y is unknown.
    Signals are weighted by their residuals; terms are added while they lower Schwarz's criterion.
    """
    used = np.array([True, angle is not None, True])
    fixed = [] if angle is not None else [ANGLE, ASIDE, OFFSETS.stop - 1]
    turn = angle or 0.0
    place, depth = _start(scan, turn, used)
    start = np.interp(place, np.arange(places.size), places), depth * float(np.median(np.diff(places)))
    size, weights = scan[used].size, np.ones(3)
    floor = EXACT * float((scan[used] ** 2).sum())
    best, score = None, np.inf
    for terms in range(1, min(TERMS, (places.size - 3) // 2) + 1):
        tried = _amplitudes(places, scan, np.array([*start, turn, 0.0]), terms, used)
        free = np.ones(tried.size, bool)
        free[fixed] = False
        for _ in range(REWEIGHTED):
            tried, squares = _fitted(tried, free, places, scan, weights * used)
            weights = _weights(squares, used)
        likely = -places.size / 2 * float(np.log(np.maximum(squares[used], floor)).sum())
        bic = int(free.sum()) * np.log(size) - 2 * likely
        if best is not None and bic > score - 2:
            break
        best, score = (tried, free), bic
        if squares[used].sum() <= floor:
            break
    assert best is not None
    parameters, free = best
    return ScanFit(parameters, _covariance(parameters, free, places, scan, used))


def _halves(parameters: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients of p and q."""
    rest = parameters[CURVES:]
    half = (rest.size + 1) // 2
    return rest[:half], rest[half:]


def _read(parameters: Floats, places: Floats) -> Floats:
    """Return T_x, T_y and S_n (3, n) of the curves."""
    along, across, normal = curves(parameters, (places - parameters[MIDDLE]) / parameters[DEPTH])
    cos, sin = np.cos(parameters[ANGLE]), np.sin(parameters[ANGLE])
    x, y = parameters[OFFSETS]
    return np.array([cos * along - sin * across + x, sin * along + cos * across + y, normal])


def _derivatives(function: Callable[[Floats], Floats], parameters: Floats, free: Flags) -> Floats:
    """Return the central differences (k, ...) of a function by the free parameters."""
    moves = np.diag(STEP * np.maximum(np.abs(parameters), 1e-2))[free]
    return np.array([(function(parameters + h) - function(parameters - h)) / (2 * h.sum()) for h in moves])


def _fitted(start: Floats, free: Flags, places: Floats, scan: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Return the fitted parameters, and the sum of squared residuals (3,) of each signal."""
    used = weights > 0

    def rest(values: Floats) -> Floats:
        parameters = start.copy()
        parameters[free] = values
        off = (_read(parameters, places) - scan)[used] * weights[used, None]
        return np.asarray(off.ravel())

    found = least_squares(rest, start[free], method="lm", x_scale="jac", max_nfev=1000, **CLOSE)
    best = start.copy()
    best[free] = found.x
    return best, np.asarray(((_read(best, places) - scan) ** 2).sum(axis=1))


def _weights(squares: Floats, used: Flags) -> Floats:
    """Return the weights of the signals from their sums of squared residuals (3,)."""
    least = LEAST_VARIANCE * float(squares[used].max())
    return np.asarray(np.sqrt(least / np.maximum(squares, least))) if least > 0 else np.ones(squares.size)


def _covariance(parameters: Floats, free: Flags, places: Floats, scan: Floats, used: Flags) -> Floats:
    """Return the covariance of the parameters, from the residuals of each signal."""
    squares = ((_read(parameters, places) - scan) ** 2).sum(axis=1)
    weights = _weights(squares, used) * used
    slope = _derivatives(lambda one: _read(one, places).ravel(), parameters, free)
    slope *= np.repeat(weights, places.size)
    count = int(used.sum()) * places.size
    variance = float((weights**2 * squares).sum()) / max(count - slope.shape[0], 1)
    size = np.sqrt((slope * slope).sum(axis=1))
    size[size == 0] = 1.0
    spread = np.linalg.pinv((slope / size[:, None]) @ (slope / size[:, None]).T) / np.outer(size, size)
    covariance = np.zeros((parameters.size, parameters.size))
    covariance[np.ix_(free, free)] = variance * spread
    return covariance


def _amplitudes(places: Floats, scan: Floats, shape: Floats, terms: int, used: Flags) -> Floats:
    """Return the parameters with the given first four, and the others by linear least squares."""
    columns = np.eye(3 + 2 * terms)
    table = np.array([_read(np.concatenate([shape, column]), places)[used].ravel() for column in columns]).T
    return np.concatenate([shape, np.linalg.lstsq(table, scan[used].ravel(), rcond=None)[0]])


def _start(scan: Floats, angle: float, used: Flags) -> tuple[float, float]:
    """Return the place and the depth, in samples, of the half-space that fits the scan best."""
    count = scan.shape[1]
    at, best = np.arange(count, dtype=np.float64), (np.inf, 0.0, 1.0)
    for depth in np.geomspace(0.5, count, WIDTHS):
        reach = np.arange(-count + 1, count) / depth
        shape = (reach**2 - 2) * (1 + reach**2) ** -2.5  # the stress peaks at the same place
        # direct convolution of a long scan takes seconds
        alike = np.abs(fftconvolve(scan[2], shape[::-1], mode="valid"))
        place = float(alike.argmax())
        near = _amplitudes(at, scan, np.array([place, depth, angle, 0.0]), 1, used)
        squares = float(((_read(near, at) - scan)[used] ** 2).sum())
        best = min(best, (squares, place, float(depth)))
    return best[1:]
