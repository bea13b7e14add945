"""Where a fit on a layer starts, compiled: the half-space's answers agree on a wrong place where the cover is thin."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.components_numba import layer_components
from tactile.inverse.least_squares.fit_numba import fit

POOR = 0.002
"""Where signals differ by more than that of the largest one, and by more than noise does, other places are tried."""
CHANCE = 3.0
"""Standard deviations of a sum of squares that are chance."""
SIDE, HALF = 7, 2.0
"""A square of so many places a side is tried, so many depths to either side of the strongest taxel, ..."""
ASKED, TAKEN, SHORT = 8, 12, 8
"""... by so many of the strongest taxels, and a short fit from so many of the best of them: none of 1500 loads on
layers of 1 to 4 depths was missed so, of 5 on taxels of strain where the half-space's answers alone were tried."""
FEW = 4
"""With fewer taxels all places are always tried, with all steps: some fit nearly as well, or as well."""
LONG = 10
"""Times the steps of a fit that are taken with fewer taxels."""
APART = 0.1
"""Places nearer than so many depths are one place."""


@kept_njit(error_model="numpy")
def layer_place(seen, felt, scale, tried, strain, layer, tie, noise, steps):  # type: ignore[no-untyped-def]
    """Return places (x, y, chi^2) from which a load on a layer may be fitted, the best of them, and the next best.

    ``tried`` (n, 3): the places on which the taxels' own answers agree, infinite where there is none.
    """
    ranked(seen, felt, scale, tried, layer, tie)
    first, second = _two_best(tried)
    load = np.zeros((1, 5))
    chi = _fitted(seen, felt, scale, tried[first], load, strain, layer, tie, steps)
    free = max(felt.size - 5.0, 1.0)
    enough = max(POOR, noise) ** 2 * (free + CHANCE * math.sqrt(2 * free))
    if chi <= enough and len(seen) >= FEW:
        tried[first, 0], tried[first, 1], tried[first, 2] = load[0, 0], load[0, 1], chi
        return tried, first, second
    few = min(len(seen), ASKED)
    square = np.zeros((SIDE * SIDE, 3))
    for k in range(SIDE * SIDE):
        square[k, 0] = HALF * (2 * (k % SIDE) / (SIDE - 1.0) - 1)
        square[k, 1] = HALF * (2 * (k // SIDE) / (SIDE - 1.0) - 1)
    ranked(seen[:few], felt[:few], scale[:few], square, layer, tie)
    taken = TAKEN if len(seen) >= FEW else len(square)
    starts = np.full((len(tried) + taken, 3), np.inf)
    for k in range(len(tried)):
        starts[k, 0], starts[k, 1], starts[k, 2] = tried[k, 0], tried[k, 1], tried[k, 2]
    for k in range(taken):
        best = 0
        for j in range(1, len(square)):
            if square[j, 2] < square[best, 2]:
                best = j
        place = starts[len(tried) + k]
        place[0], place[1], place[2] = square[best, 0], square[best, 1], square[best, 2]
        square[best, 2] = np.inf
    for k in range(len(starts)):
        if starts[k, 2] < np.inf:
            most = SHORT if few >= FEW else LONG * steps  # valleys of so few signals are long
            chi = _fitted(seen[:few], felt[:few], scale[:few], starts[k], load, strain, layer, tie, most)
            starts[k, 0], starts[k, 1], starts[k, 2] = load[0, 0], load[0, 1], chi
    if few < len(seen):
        ranked(seen, felt, scale, starts, layer, tie)
    first, second = _two_best(starts)
    return starts, first, second


@kept_helper(error_model="numpy")
def ranked(seen, felt, scale, places, layer, tie):  # type: ignore[no-untyped-def]
    """Fill in what a load at each of the places (x, y, chi^2) leaves; places that are infinite stay so."""
    load = np.empty(5)
    for k in range(len(places)):
        if places[k, 2] < np.inf:
            load[0], load[1] = places[k, 0], places[k, 1]
            places[k, 2] = layer_components(seen, felt, scale, load, layer, tie)


@kept_helper(error_model="numpy")
def _fitted(seen, felt, scale, place, load, strain, layer, tie, steps):  # type: ignore[no-untyped-def]
    load[0, 0], load[0, 1] = place[0], place[1]
    layer_components(seen, felt, scale, load[0], layer, tie)
    chi, _, _ = fit(seen, felt, scale, load, strain, layer, tie, steps)
    return chi


@kept_helper(error_model="numpy")
def _two_best(places):  # type: ignore[no-untyped-def]
    """Return which place leaves least, and which of those apart from it; the same where there is none."""
    first = 0
    for k in range(1, len(places)):
        if places[k, 2] < places[first, 2]:
            first = k
    second = first
    for k in range(len(places)):
        apart = (places[k, 0] - places[first, 0]) ** 2 + (places[k, 1] - places[first, 1]) ** 2 > APART * APART
        if places[k, 2] < np.inf and apart and (second == first or places[k, 2] < places[second, 2]):
            second = k
    return first, second
