"""Several point loads at once: fits from the peaks of the signals, and the number of loads that explains them."""

import math
from itertools import combinations

import numpy as np

from cnnsim.support import Flags, Floats, Integers
from tactile.inverse.limits import LARGE_PAD, LOADS, LOADS_APART, PEAK, POINT
from tactile.inverse.single_fit import Candidate, LoadFit, Taxels, fitted

PEAKS, TRIES = 6, 8
"""Highest peaks from which fits start, and combinations of them for each number of loads."""
FEWER_TAXELS, MORE_LOADS, INSTEAD = 10.0, 4.0, 2.0
"""Factors by which a model must leave less variance if it has a taxel less (3 times that of up to 8 taxels), one load
more, or one load more in place of a taxel less."""
EXPLAINED = 0.01
"""Misfit below which no more loads are looked for."""
NO_MORE = 0.75
"""One load more that leaves this part of chi^2 explains noise: of four equal loads the second explains a third."""
LARGER_THAN = 3.0
"""Standard deviations that a load must exceed."""
MOST, NEAR = 30, 2.5
"""Largest number of loads on a large pad, and half the side [depths] of the square for the statistics of each."""
QUIET, ABOVE, ALONE = 0.1, 12.0, 0.05
"""A peak is `ABOVE` times the quantile `QUIET` of the signals (noise: none in a million signals); where no
neighbour reads `ALONE` times the peak, the reading is false."""
COARSE = 1.5
"""Pitch [depths] up to which a load above a taxel also gives its neighbours a signal."""


def ranked(fit: LoadFit) -> LoadFit:
    """Return the fit with the strongest of its loads first."""
    rank = np.argsort(-np.hypot(np.hypot(*fit.loads[:, 2:4].T), fit.loads[:, 4]))
    k = (5 * rank[:, None] + np.arange(5)).ravel()
    covariance = np.ascontiguousarray(fit.covariance[np.ix_(k, k)])
    return LoadFit(fit.signals, fit.loads[rank], (fit.chi, fit.whole, covariance, fit.rest, fit.stranger))


def several(taxels: Taxels, one: Candidate) -> list[Candidate]:
    """Return fits of 2 to `LOADS` loads, `LOADS_APART` or more from each other, the simplest first.

    For each number of loads: the best fit with all taxels, and the best without the taxel of the largest residual, if
    their misfit is at most `POINT`.

    Fits start from the highest peaks, and from the best fit so far with one load more at its largest residual.
    """
    starts, found, before = _small_pad_peaks(taxels), [], one.fit
    for count in range(2, min(LOADS, len(one.order) // 5) + 1):
        ways = sorted(combinations(range(len(starts)), count), key=lambda ranks: (sum(ranks), ranks))[:TRIES]
        best: list[LoadFit | None] = [None, None]
        left = before.chi
        for start in [_with_one_more(before), *(np.array([starts[k] for k in ranks]) for ranks in ways)]:
            fit = fitted(one.fit.signals, start)
            if fit.chi < before.chi:
                before = fit
            fits = [fit]
            if fit.misfit > EXPLAINED:
                fits.append(fitted(fit.signals.without(int(fit.worst[0])), fit.loads))
            for k, new in enumerate(fits):
                old = best[k]
                if new.misfit <= POINT and (old is None or new.misfit < old.misfit) and _distinct(new):
                    best[k] = new
            if any(fit is not None and fit.misfit <= EXPLAINED for fit in best):
                break
        found += [Candidate(ranked(fit), one.top, False) for fit in best if fit is not None]
        if any(way.fit.misfit <= EXPLAINED for way in found) or before.chi > NO_MORE * left:
            break
    return found


def simplest(ways: list[Candidate]) -> Candidate:
    """Return the simplest candidate; a later one replaces it only if it leaves far less variance."""
    chosen = ways[0]
    for way in ways[1:]:
        fewer, more = len(way.order) < len(chosen.order), len(way.fit.loads) > len(chosen.fit.loads)
        factor = 1.0
        if fewer:
            factor *= FEWER_TAXELS if len(chosen.order) > 8 else 3 * FEWER_TAXELS
        if more:
            instead = len(way.order) > len(chosen.order)
            factor *= INSTEAD if instead else MORE_LOADS if chosen.fit.misfit > POINT else FEWER_TAXELS
        if way.left * factor < chosen.left:
            chosen = way
    return chosen


def _with_one_more(fit: LoadFit) -> Floats:
    """Return the loads of a fit and one that presses above its largest residual."""
    worst = fit.worst[0]
    x, y = fit.signals.seen[worst]
    return np.concatenate([fit.loads, [[x, y, 0.0, 0.0, math.sqrt(float((fit.rest[worst] ** 2).sum())) / 2]]])


def _distinct(fit: LoadFit) -> bool:
    """Whether all loads are well apart and larger than their uncertainty."""
    size = np.abs(fit.loads[:, 2:]).max(axis=1)
    large = (size > LARGER_THAN * np.sqrt(fit.variance * fit.spread[:, 2:].max(axis=1))).all()
    return bool(large) and not close_pairs(fit.loads).any()


def close_pairs(loads: Floats) -> Flags:
    """Return which loads (k, 5) have another one nearer than `LOADS_APART`."""
    gaps = np.hypot(*(loads[:, None, :2] - loads[None, :, :2]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    close: Flags = (gaps < LOADS_APART).any(axis=1)
    return close


def _small_pad_peaks(taxels: Taxels) -> list[list[float]]:
    """Return starts of loads that press at the highest local maxima of the signals, the highest first."""
    from scipy.ndimage import maximum_filter  # slow to import, rarely needed

    height = taxels.peak.reshape(taxels.shape)
    high = (maximum_filter(height, 3) == height) & (height > 0)
    peaks = sorted(np.flatnonzero(high).tolist(), key=lambda n: -taxels.peak[n])[:PEAKS]
    return [_start(taxels, n) for n in peaks]


def _start(taxels: Taxels, n: int) -> list[float]:
    """Return the start of a load that presses where taxel n locates it, or above it."""
    first, answer = taxels.order[0], taxels.planes[0, :2, n]
    near = answer if np.hypot(*answer) <= taxels.depth else 0.0
    x, y = (taxels.at[n] - taxels.at[first] + near) / taxels.depth
    return [float(x), float(y), 0.0, 0.0, float(taxels.peak[n] / taxels.peak[first]) / 2]


def large_pad(taxels: Taxels, one: Candidate) -> Candidate | None:
    """Return a joint fit of one load at each peak of a large pad, `MOST` at most, None if one load explains the pad.

    A peak without a signal on any neighbouring taxel is false and not used.
    """
    fit = one.fit
    if min(taxels.shape) <= LARGE_PAD:
        return None
    pitch = float(np.abs(taxels.at[taxels.shape[1]] - taxels.at[0]).max())
    if pitch > COARSE * taxels.depth:
        return None
    left = float(np.abs(fit.rest).max())
    if left < PEAK / 2 or (fit.foreign is None and left < 6 * math.sqrt(fit.chi / max(fit.free, 1))):
        return None
    peaks, alone = _peaks(taxels, pitch)
    if len(peaks) < 2:
        return None
    keep = ~np.isin(fit.signals.cells, alone)
    signals = fit.signals._replace(
        seen=fit.signals.seen[keep], measured=fit.signals.measured[keep], scale=fit.signals.scale[keep],
        cells=fit.signals.cells[keep],
    )  # fmt: skip
    starts = np.array([_start(taxels, int(n)) for n in peaks[:MOST]])
    return Candidate(ranked(fitted(signals, starts)), one.top, False)


def _peaks(taxels: Taxels, pitch: float) -> tuple[Integers, Integers]:
    """Return the taxels of the local maxima within a depth, the highest first, and of false ones."""
    from scipy.ndimage import maximum_filter  # slow to import, and only for large pads

    height = taxels.peak.reshape(taxels.shape)
    near = 2 * max(1, round(taxels.depth / pitch)) + 1
    floor = max(PEAK * float(height.max()), ABOVE * float(np.quantile(height, QUIET)))
    around = np.ones((3, 3), bool)
    around[1, 1] = False
    measured = maximum_filter(height, footprint=around, mode="constant") > ALONE * height
    high = (maximum_filter(height, near) == height) & (height > floor)
    peaks = np.flatnonzero(high & measured)
    return peaks[np.argsort(-taxels.peak[peaks])], np.flatnonzero(high & ~measured)


def local_statistics(fit: LoadFit) -> tuple[Floats, Floats, Floats]:
    """Return the variance of a signal, the excess and the misfit (k,) of each load from the square `NEAR` around it."""
    signals, noise, found = fit.signals, fit.signals.noise or 0.0, np.zeros((3, len(fit.loads)))
    for k, load in enumerate(fit.loads):
        near = np.abs(signals.seen - load[:2]).max(axis=1) < NEAR
        chi, whole = float((fit.rest[near] ** 2).sum()), float((signals.measured[near] ** 2).sum())
        random, free = fit.random * float(near.mean()), max(3 * int(near.sum()) - 5, 1)
        misfit = math.sqrt(min(max(chi - random, 0.0) / max(whole - random, random, 1e-300), 1.0))
        found[:, k] = max(chi / free, noise * noise), max(chi - random, 0.0) if random else 0.0, misfit
    return found[0], found[1], found[2]
