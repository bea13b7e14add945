"""Several point loads at once: where the signals have their peaks, as many as leave little unexplained."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np

from cnnsim.support import Floats
from tactile.inverse.attempt import Attempt, Taxels
from tactile.inverse.least_squares.fit import Fit, fitted

MOST, PEAKS, TRIES = 4, 6, 8
"""So many loads are looked for, from so many of the highest peaks, in so many ways for each number of them."""
APART = 2.0
"""Loads nearer to each other than so many depths are one patch, not two points."""
FEWER_TAXELS, MORE_LOADS, INSTEAD = 10.0, 4.0, 2.0
"""How many times less of a variance an answer must leave that leaves a taxel out (ten times that of up to 8 taxels), or
has one load more, or one load more in the place of a taxel left out."""
EXPLAINED = 0.01
"""Where no more is left unexplained nobody looks further."""
LESS = 0.75
"""One load more that leaves more of what was left explains noise alone, and yet another will no better: of four equal
loads the second explains a third."""
SURE = 3.0
"""A load counts if it is so many standard deviations large."""


def several(taxels: Taxels, one: Attempt, most: float) -> list[Attempt]:
    """Return what explains the signals as 2 to 4 loads well apart, the simplest first, leaving ``most`` or less.

    Each number of them stands there twice where that helps: with all taxels, and without the one that contradicts.
    Fits start from the highest peaks, and from the loads found before with one where most is left.
    """
    starts, found, before = _peaks(taxels), [], one.fit
    for count in range(2, MOST + 1):
        if len(one.order) < 5 * count:
            break
        ways = sorted(combinations(range(len(starts)), count), key=lambda ranks: (sum(ranks), ranks))[:TRIES]
        best: list[Fit | None] = [None, None]
        left = before.chi
        for start in [_with_one_more(before), *(np.array([starts[k] for k in ranks]) for ranks in ways)]:
            fit = fitted(one.fit.signals, start)
            if fit.chi < before.chi:
                before = fit
            for k, new in enumerate([fit] if fit.misfit <= EXPLAINED else [fit, _without_worst(fit)]):
                old = best[k]
                if new.misfit <= most and (old is None or new.misfit < old.misfit) and _apart(new) and _sure(new):
                    best[k] = new
            if any(fit is not None and fit.misfit <= EXPLAINED for fit in best):
                break
        found += [_attempt(fit, one.top) for fit in best if fit is not None]
        if any(attempt.fit.misfit <= EXPLAINED for attempt in found) or before.chi > LESS * left:
            break
    return found


def simplest(ways: list[Attempt], point: float) -> Attempt:
    """Return the first of attempts, the simplest first, that no later one betters by far.

    ``point``: what leaves less may be one load that is no point, and needs more to be called several.
    """
    chosen = ways[0]
    for way in ways[1:]:
        fewer, more = len(way.order) < len(chosen.order), len(way.fit.loads) > len(chosen.fit.loads)
        wanted = 1.0
        if fewer:
            wanted *= FEWER_TAXELS if len(chosen.order) > 8 else 3 * FEWER_TAXELS  # so few fit anything without one
        if more:
            instead = len(way.order) > len(chosen.order)
            wanted *= INSTEAD if instead else MORE_LOADS if chosen.fit.misfit > point else FEWER_TAXELS
        if way.left * wanted < chosen.left:
            chosen = way
    return chosen


def _with_one_more(fit: Fit) -> Floats:
    """Return the loads of a fit and one that presses where it leaves most, as fits start."""
    worst = fit.contrary[0]
    x, y = fit.signals.seen[worst]
    size = math.sqrt(float((fit.rest[worst] ** 2).sum())) / 2
    return np.concatenate([fit.loads, [[x, y, 0.0, 0.0, size]]])


def _attempt(fit: Fit, top: float) -> Attempt:
    rank = np.argsort(-np.hypot(np.hypot(*fit.loads[:, 2:4].T), fit.loads[:, 4]))
    fit.loads, fit.spread = fit.loads[rank], fit.spread[rank]
    return Attempt(fit.signals.cells, fit, top, False)


def as_ranked(found: Attempt) -> Attempt:
    """Return the attempt with the strongest of its loads first."""
    ranked = _attempt(found.fit, found.top)
    return replace(found, fit=ranked.fit)


def _without_worst(fit: Fit) -> Fit:
    """Return the fit without the taxel that contradicts it most."""
    return fitted(fit.signals.without(int(fit.contrary[0])), fit.loads)


def _apart(fit: Fit) -> bool:
    return all(np.hypot(*(a - b)) >= APART for a, b in combinations(fit.loads[:, :2], 2))


def _sure(fit: Fit) -> bool:
    """Whether every load is larger than its uncertainty."""
    size = np.abs(fit.loads[:, 2:]).max(axis=1)
    return bool((size > SURE * np.sqrt(fit.variance * fit.spread[:, 2:].max(axis=1))).all())


def _peaks(taxels: Taxels) -> list[list[float]]:
    """Return loads that press where a taxel feels more than its neighbours, the strongest first, as fits start."""
    from scipy.ndimage import maximum_filter  # slow to import, seldom wanted

    height = taxels.peak.reshape(taxels.shape)
    high = (maximum_filter(height, 3) == height) & (height > 0)
    first = taxels.order[0]
    ranked = sorted(np.flatnonzero(high).tolist(), key=lambda n: -taxels.peak[n])[:PEAKS]
    top = taxels.peak[first]
    answers = taxels.planes[0, :3]
    near = np.hypot(answers[0], answers[1]) <= taxels.depth
    starts = []
    for n in ranked:
        x, y = (taxels.at[n] - taxels.at[first] + (answers[:2, n] if near[n] else 0.0)) / taxels.depth
        starts.append([float(x), float(y), 0.0, 0.0, float(taxels.peak[n] / top) / 2])
    return starts
