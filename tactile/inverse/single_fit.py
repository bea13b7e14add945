"""Fits of point loads to the signals of all taxels: signals, fit with its statistics, and the best single load."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.inverse.limits import (
    CHANCE,
    DOUBT,
    FOREIGN_MEDIAN,
    NOISE_FROM,
    RIVAL,
    RIVAL_SIGMAS,
    SAME,
    SMALL_SHARE,
    UNOBSERVABLE,
    UNSURE,
    USUAL_NOISE,
)
from tactile.inverse.validity import Validity
from tactile.inverse.weights import TaxelSignals, Weights

NO_DIFFERENCE = 1e-24
"""Share of the signals' energy below which two places explain them alike: rounding."""
OBSERVED_SHEAR = 0.2
"""Shear across a line of taxels on a layer is given if its deviation is below this part of the normal force."""
LOOSE = 12.0
"""Twice the relative error of a variance from the tenth's quantile of n numbers, times the root of n."""


class LoadFit:
    """Loads (k, 5) fitted to signals, in depths and in the scale of the signals.

    ``chi``: sum of the squares of the residuals ``rest`` (n, 3), ``whole``: of the signals; ``covariance`` (5 k, 5 k)
    for signals of variance 1; ``free``: degrees of freedom; ``variance`` of a signal: that of the noise or of the
    residuals, the larger one, NaN if both are unknown; ``random``, ``excess``, ``misfit``: see `misfits`.
    """

    def __init__(self, signals: TaxelSignals, loads: Floats, fitted: tuple[Any, ...]) -> None:
        from tactile.inverse.fit_numba import misfits  # numba is slow to import

        self.signals, self.loads = signals, loads
        self.chi, self.whole, self.covariance, self.rest, self.stranger = fitted
        self.spread: Floats = np.diagonal(self.covariance).reshape(-1, 5)
        xx, xy, yy = signals.tie.tolist()
        observed = 2 if xx + yy == 0 else int(xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2)
        self.free = max(signals.measured.size - signals.lost - (3 + observed) * len(loads), 0)
        left, noise = self.chi / self.free if self.free else math.nan, signals.noise
        self.variance = left if noise is None or left > noise * noise else noise * noise
        known, taxels = noise or 0.0, len(signals.seen)
        estimate = 0.0
        if noise is None and taxels >= NOISE_FROM and self.chi >= SMALL_SHARE * self.whole:
            estimate = _noise_energy(signals, self.rest, self.chi)
        self.random, self.excess, self.misfit = misfits(self.chi, self.whole, taxels, self.free, known, estimate)

    @cached_property
    def foreign(self) -> int | None:
        """The taxel out of reach with the largest signal of another load, None without such a load."""
        squares = (self.rest**2).sum(axis=1)
        found = self.stranger >= 0 and squares[self.stranger] > FOREIGN_MEDIAN * np.median(squares)
        return self.stranger if found else None

    @cached_property
    def tests(self) -> tuple[float, float, int, bool]:
        """Results of the tests of `residual_tests_numba.unexplained` for a single load."""
        return self._unexplained[1]

    @property
    def unexplained(self) -> Floats:
        """Variances (k, 5) of the loads due to residuals beyond the noise, in depths and scaled like the signals."""
        return self._unexplained[0]

    @cached_property
    def _unexplained(self) -> tuple[Floats, tuple[float, float, int, bool]]:
        from tactile.inverse.residual_tests_numba import unexplained  # numba is slow to import

        if len(self.loads) > 1:
            return self.excess * self.spread, (0.0, 0.0, 0, False)
        more, noise = np.empty((1, 5)), self.signals.noise or 0.0
        numbers = noise, self.chi, self.excess, self.free, self.covariance, more[0]
        return more, unexplained(self.signals[:6], self.loads[0], *numbers)

    @property
    def unsure(self) -> float:
        """Standard deviation of the first load's place in depths, with `USUAL_NOISE` where the noise is unknown."""
        deviation = math.sqrt(self.variance)
        if self.signals.noise is None and not deviation > USUAL_NOISE:
            deviation = USUAL_NOISE
        return deviation * math.sqrt(max(self.spread[0, :2].tolist()))

    @cached_property
    def worst(self) -> Integers:
        """The taxels by their residuals, the largest first."""
        return np.argsort(-(self.rest**2).sum(axis=1), kind="stable")


def _noise_energy(signals: TaxelSignals, rest: Floats, chi: float) -> float:
    """Return the part of chi^2 that is noise, estimated from residuals (n, 3).

    The noise is that of the median residual, or of the weakest signals if smaller; correlated residuals of neighbouring
    taxels are a smooth field and no noise.
    """
    (rows, cols), size = signals.shape, rest.size
    quantiles = ((rest, 0.5, 0.6745), (signals.measured, 0.1, 0.1257))  # of |x| for normal x of variance 1
    noise = min(
        np.partition(np.abs(values).ravel(), int(part * size))[int(part * size)] / quantile
        for values, part, quantile in quantiles
    )
    grid: Floats = np.zeros((rows, cols, 3))
    grid.reshape(-1, 3)[signals.cells] = rest
    alike = (grid[1:] * grid[:-1]).sum() + (grid[:, 1:] * grid[:, :-1]).sum()
    pairs = (rows - 1) * cols + rows * (cols - 1)
    likeness = np.clip(alike / pairs * rows * cols / chi - CHANCE / math.sqrt(3.0 * pairs), 0.0, 1.0)
    return float(min(noise**2 * (size + LOOSE * math.sqrt(size)), chi * (1 - likeness)))


def fitted(signals: TaxelSignals, start: Floats) -> LoadFit:
    """Return the fit from a start on: loads (k, 5), or the place (1, 2) of one."""
    from tactile.inverse.fit_numba import fit  # numba is slow to import

    loads = np.zeros((len(start), 5))
    loads[:, : start.shape[1]] = start
    return LoadFit(signals, loads, fit(signals[:6], loads, signals.noise or 0.0, start.shape[1] == 2))


def made(signals: TaxelSignals, loads: Floats) -> Floats:
    """Return the signals (n, 3) of loads (k, 5) at the places of these signals."""
    from tactile.inverse.field_numba import residual  # numba is slow to import

    nothing = np.zeros_like(signals.measured)
    return -residual(signals.seen, nothing, signals.scale, loads, signals.strain, signals.layer)


@dataclass(frozen=True)
class Candidate:
    """A model of the signals: a fit, the signal ``top`` [N] that is scaled to 1, and whether another one fits as well.

    ``clipped``, ``false``: taxels of which a reading is not used, since it is clipped or contradicts all others.
    """

    fit: LoadFit
    top: float
    ambiguous: bool
    clipped: tuple[int, ...] = ()
    false: tuple[int, ...] = ()

    @property
    def order(self) -> Integers:
        """The taxels that are used, the strongest first."""
        return self.fit.signals.cells

    @property
    def left(self) -> float:
        """Residual variance [N^2] beyond the noise."""
        chance = self.fit.random * math.sqrt(2 / max(self.fit.free, 1))
        return max(self.fit.chi - self.fit.random, chance) / max(self.fit.free, 1) * self.top**2


class Taxels:
    """Inverse planes (families, 4, n) of the taxels of a frame, at places (rows, cols, 2) [m], with signal weights.

    ``order``: the taxels that have an answer, the strongest first.
    """

    def __init__(self, at: Floats, planes: Floats, depth: float, strain: bool, weights: Weights, layer: Floats) -> None:
        from tactile.inverse.start_numba import strongest  # numba is slow to import

        self.shape: tuple[int, int] = at.shape[0], at.shape[1]
        self.at, self.planes, self.depth, self.strain, self.layer = at.reshape(-1, 2), planes, depth, strain, layer
        self.noise, self.scale, self.trust = weights
        self.signal, self.peak, self.order = strongest(planes, self.trust, depth, strain)

    def single(self, order: Integers, *, thorough: bool = False) -> Candidate:
        """Return the best single load for these taxels, the strongest of them first.

        ``thorough``: the best of the fits from all places that were tried.
        """
        from tactile.inverse.single_fit_numba import one_load  # numba is slow to import

        top = float(self.peak[order[0]])
        noise = None if self.noise is None else self.noise / top
        weights, units = (self.signal, self.trust, self.scale), (self.depth, self.strain, self.layer, top)
        tried, first, second, (seen, measured, scale, strain, layer, tie), loads, result = one_load(
            self.at, self.planes, weights, order, units, noise or 0.0
        )
        signals = TaxelSignals(seen, measured, scale, strain, layer, tie, order, self.shape, noise)
        fit, rival = LoadFit(signals, loads, result), tried[second]
        if thorough:
            places = [place for place in tried if np.isfinite(place[2])]
            fits = [fitted(self._signals(order, place, noise), place[None, :2]) for place in places]
            fit = min(fits, key=lambda one: one.chi)
        ambiguous = False
        # one taxel: a pull elsewhere fits as well, and pressing is assumed
        if len(order) > 1 and rival[2] < RIVAL * tried[first, 2]:
            other = fitted(fit.signals, rival[None, :2])
            if math.dist(other.loads[0, :2], fit.loads[0, :2]) > SAME:
                fit, other = sorted((fit, other), key=lambda one: one.chi)
                beyond = (RIVAL - 1) * max(fit.chi - fit.random, 0.0) + RIVAL_SIGMAS**2 * fit.random / max(fit.free, 1)
                similar = min(fit.chi + beyond, RIVAL * fit.chi) if fit.random else RIVAL * fit.chi
                ambiguous = other.chi < max(similar, NO_DIFFERENCE * fit.whole)
        if len(order) == 1 or fit.unsure > UNSURE:
            fit = self._without_shear(fit, int(order[0]))
        elif len(self.layer) and fit.signals.tie.any():
            fit = _with_all_shear(fit)
        if len(order) == 1:
            ambiguous = self._silent_nearer(fit, int(order[0]))
        return Candidate(fit, top, ambiguous or fit.unsure > UNSURE)

    def _signals(self, order: Integers, place: Floats, noise: float | None) -> TaxelSignals:
        """Return the signals of these taxels, by the answers nearest to a place."""
        from tactile.inverse.start_numba import signals  # numba is slow to import

        top = float(self.peak[order[0]])
        seen, measured, scale, tie = signals(
            self.at, self.planes, self.scale, order, place, self.depth, self.strain, top
        )
        return TaxelSignals(seen, measured, scale, self.strain, self.layer, tie, order, self.shape, noise)

    def _silent_nearer(self, fit: LoadFit, first: int) -> bool:
        """Whether the only taxel with an answer locates it outside, nearer to a taxel without signal."""
        away = fit.loads[0, :2] - fit.signals.seen[0]
        silent = (self.planes[:, 3] == Validity.NO_LOAD).all(axis=0)
        if (away**2).sum() < 2 or not silent.any():
            return False
        gaps = np.hypot(*(self.at - self.at[first] - away * self.depth).T)
        return bool(gaps[silent].min() < gaps[first])

    def _without_shear(self, fit: LoadFit, first: int) -> LoadFit:
        """Return the fit of a pressing load without shear if its misfit is below `DOUBT`, else the given fit."""
        dx, dy, _, validity = self.planes[0, :, first].tolist()
        if validity not in (Validity.INSIDE, Validity.OUTSIDE):
            return fit
        start = np.array([[dx / self.depth, dy / self.depth]])
        pressing = fitted(fit.signals._replace(tie=np.array([UNOBSERVABLE, 0.0, UNOBSERVABLE])), start)
        return pressing if pressing.misfit < DOUBT else fit


def _with_all_shear(fit: LoadFit) -> LoadFit:
    """Return the fit with the shear across a line of taxels if it is observable, as on a thin layer."""
    free = fitted(fit.signals._replace(tie=np.zeros(3)), fit.loads)
    if not np.isfinite(free.spread).all():
        return fit
    deviation = free.unsure * math.sqrt(free.spread[0, 2:].max() / free.spread[0, :2].max())
    return free if deviation < OBSERVED_SHEAR * abs(free.loads[0, 4]) and free.unsure < UNSURE else fit
