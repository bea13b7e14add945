"""Attempt: one load from the taxels of one frame, or from some of them: their consensus, then least squares."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats
from tactile.inverse.least_squares.fit import (
    ALL,
    FOREIGN,
    MANY,
    REACH,
    SAME,
    STEPS,
    TIED,
    Fit,
    Signals,
    fitted,
    least_foreign,
)
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights

SEEDS = 3
"""The candidates of that many of the strongest taxels are tried as the place."""
VOTERS = 16
"""That many of the strongest taxels vote on the place: the others add noise to a start, all of them are fitted then."""
RIVAL = 3.0
"""A second place that fits less than so many times worse than the best leaves the answer ambiguous."""
ROUNDING = 1e-24
"""Two places of which both leave a smaller share of the signals' energy explain them alike."""
UNSURE = 0.5
"""A place that is not known to so many depths is none."""
DOUBT = 0.05
"""From this share on loads do not explain the signals well."""
UNTOLD = 0.2
"""Shear that is not known to that part of the normal force is not told."""


@dataclass(frozen=True)
class Attempt:
    """A fit to the taxels in ``order``, the strongest first, and whether another place fits about as well.

    ``top``: the signal [N] that the fit has as 1; ``clipped``: taxels of which the largest reading is not used,
    since it is cut off; ``false``: those of which one is not, since it contradicts all others.
    """

    order: NDArray[np.intp]
    fit: Fit
    top: float
    ambiguous: bool
    clipped: tuple[int, ...] = ()
    false: tuple[int, ...] = ()

    @property
    def left(self) -> float:
        """What is left [N^2] beyond the noise, per degree of freedom."""
        chance = self.fit.random * math.sqrt(2 / max(self.fit.free, 1))
        return max(self.fit.chi - self.fit.random, chance) / max(self.fit.free, 1) * self.top**2


class Taxels:
    """The answers of all taxels of one frame, at places (rows, cols, 2) [m], as planes (families, 4, n).

    ``order``: the taxels that have one, first the strongest, in order; ``weights`` of their signals.
    """

    def __init__(self, at: Floats, planes: Floats, depth: float, strain: bool, weights: Weights, layer: Floats) -> None:
        from tactile.inverse import consensus_numba  # numba is slow to import

        self.shape: tuple[int, int] = at.shape[0], at.shape[1]
        self.at, self.planes, self.depth, self.strain, self.layer = at.reshape(-1, 2), planes, depth, strain, layer
        self.noise, self.scale, self.trust = weights
        self.signal, self.peak, self.order = consensus_numba.strongest(planes, self.trust, depth, strain, VOTERS)

    def attempt(self, order: NDArray[np.intp], *, thorough: bool = False) -> Attempt:
        """Return the best single load for these taxels, the strongest of them first.

        ``thorough``: from every place that was tried, not only from that where most agree.
        """
        tried, first, second, fit = self._at_one_go(order)
        rival = tried[second]
        if thorough:
            places = [place for place in tried if np.isfinite(place[2])]
            fit = min((fitted(self.felt(order, place), place[None, :2]) for place in places), key=lambda one: one.chi)
        ambiguous = False
        # to one taxel a pull fits as well: it is taken to be pressed
        if len(order) > 1 and rival[2] < RIVAL * tried[first, 2]:
            other = fitted(fit.signals, rival[None, :2])
            if math.dist(other.loads[0, :2], fit.loads[0, :2]) > SAME:
                fit, other = sorted((fit, other), key=lambda one: one.chi)
                ambiguous = other.chi < max(RIVAL * fit.chi, ROUNDING * fit.whole)
        if len(order) == 1 or fit.unsure > UNSURE:
            fit = self._pressing(fit, int(order[0]))
        elif len(self.layer) and fit.signals.tie.any():
            fit = self._untied(fit)
        if len(order) == 1:
            ambiguous = self._silent_nearer(fit, int(order[0]))
        return Attempt(order, fit, float(self.peak[order[0]]), ambiguous or fit.unsure > UNSURE)

    def _silent_nearer(self, fit: Fit, first: int) -> bool:
        """Whether a taxel that feels nothing lies nearer to a place outside than the only taxel that has an answer."""
        away = fit.loads[0, :2] - fit.signals.seen[0]
        silent = (self.planes[:, 3] == Validity.NO_LOAD).all(axis=0)
        if (away**2).sum() < 2 or not silent.any():
            return False
        gaps = np.hypot(*(self.at - self.at[first] - away * self.depth).T)
        return bool(gaps[silent].min() < gaps[first])

    def _pressing(self, fit: Fit, first: int) -> Fit:
        """Return the fit without shear if it explains as much: one taxel alone feels the load, pressing."""
        dx, dy, _, validity = self.planes[0, :, first].tolist()
        if validity not in (Validity.INSIDE, Validity.OUTSIDE):
            return fit
        start = np.array([[dx / self.depth, dy / self.depth]])
        held = fitted(fit.signals._replace(tie=np.array([TIED, 0.0, TIED])), start)
        return held if held.misfit < DOUBT else fit

    def _untied(self, fit: Fit) -> Fit:
        """Return the fit with the shear across a line of taxels, which they tell on a thin layer, if it is told."""
        free = fitted(fit.signals._replace(tie=np.zeros(3)), fit.loads)
        if not np.isfinite(free.spread).all():
            return fit
        told = free.unsure * math.sqrt(free.spread[0, 2:].max() / free.spread[0, :2].max())
        return free if told < UNTOLD * abs(free.loads[0, 4]) and free.unsure < UNSURE else fit

    def _at_one_go(self, order: NDArray[np.intp]) -> tuple[Floats, int, int, Fit]:
        """Return the places that were tried, the best, the next best, and the fit from the best on."""
        from tactile.inverse.attempt_numba import one_load  # as above

        noise, top = self._noise(order)
        tried, first, second, seen, felt, scale, tie, *rest = one_load(
            self.at, self.planes, self.signal, self.trust, self.scale, order, self.depth, self.strain, self.layer,
            top, noise or 0.0, VOTERS, SEEDS, STEPS, REACH, least_foreign(noise), FOREIGN[1], ALL, MANY,
        )  # fmt: skip
        signals = Signals(seen, felt, scale, self.strain, self.layer, tie, order, self.shape, noise)
        return tried, first, second, Fit(signals, *rest)

    def felt(self, order: NDArray[np.intp], place: Floats) -> Signals:
        """Return the signals of these taxels, by the answers nearest to a place."""
        from tactile.inverse import consensus_numba as loops  # as above

        noise, top = self._noise(order)
        seen, felt, scale, tie = loops.signals(
            self.at, self.planes, self.scale, order, place, self.depth, self.strain, top
        )
        return Signals(seen, felt, scale, self.strain, self.layer, tie, order, self.shape, noise)

    def _noise(self, order: NDArray[np.intp]) -> tuple[float | None, float]:
        """Return the noise over the largest signal, and that [N]."""
        top = float(self.peak[order[0]])
        return None if self.noise is None else self.noise / top, top
