"""Several point loads at once: where the signals have their peaks, as many as leave little unexplained."""

from itertools import combinations

import numpy as np

from tactile.inverse.attempt import Attempt, Taxels
from tactile.inverse.fit import Fit

MOST, PEAKS, TRIES = 4, 6, 6
"""So many loads are looked for, from so many of the highest peaks, in so many ways for each number of them."""
APART = 2.0
"""Loads nearer to each other than so many depths are one patch, not two points."""
BETTER = 0.5
"""One more load must halve what is left."""
SURE = 3.0
"""A load counts if it is so many standard deviations large."""


def several(taxels: Taxels, one: Attempt, enough: float, most: float) -> Attempt | None:
    """Return the fewest loads, 2 to 4, that leave at most ``enough`` unexplained, or those that leave least.

    None where no few well apart leave ``most`` or less.
    """
    starts, found = _peaks(taxels), None
    for count in range(2, MOST + 1):
        if len(one.order) < 5 * count or (found and found.misfit <= enough):
            break
        for chosen in list(combinations(starts, count))[:TRIES]:
            fit = Fit(one.fit.signals, np.array(chosen))
            better = fit.misfit < (BETTER * found.misfit if found else most)
            if better and _apart(fit) and _sure(fit):
                found = fit
                break
    if found is None:
        return None
    rank = np.argsort(-np.hypot(np.hypot(*found.loads[:, 2:4].T), found.loads[:, 4]))
    found.loads, found.spread = found.loads[rank], found.spread[rank]
    return Attempt(one.order, found, one.top, False)


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
