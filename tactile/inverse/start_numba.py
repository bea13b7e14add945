"""Start of the load fit, compiled: answers of the single taxels, the place they agree on, and the scaled signals.

Lengths are in depths, seen from the strongest taxel; ``planes`` (families, 4, taxels) are the taxel inverse's, one
family for loads that press and for strain another one for loads that pull.
"""

import math

import numpy as np
from numba import njit

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.fit_numba import forces, least_squares
from tactile.inverse.limits import CHANCE, FEWEST, SAME, SEEDS, STEPS, UNOBSERVABLE, VOTERS
from tactile.inverse.validity import Validity

INSIDE, OUTSIDE = float(Validity.INSIDE), float(Validity.OUTSIDE)
STRAIGHT = 1e-5
"""Slope below which a line of taxels is parallel to an axis."""
SIDE, HALF, TAXELS, TAKEN = 7, 2.0, 8, 12
"""On layers a square of `SIDE`^2 places up to `HALF` from the strongest taxel is ranked by `TAXELS` taxels; the best
`TAKEN` are fitted. The half-space's answers alone miss 5 of 1500 loads on layers of 1 to 4 depths, this none."""
GOOD = 0.002
"""Residual per signal below which no other place is tried on a layer."""


@kept_njit(error_model="numpy")
def strongest(planes, trust, depth, strain):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return the signals (families, taxels), each taxel's largest, and the taxels with an answer, strongest first.

    Signals are compared times ``trust``. Only the first `VOTERS` are in order: numba needs a second to compile a sort.
    """
    families, _, taxels = planes.shape
    signal, peak, count = np.zeros((families, taxels)), np.zeros(taxels), 0
    order = np.empty(taxels, np.int64)
    for n in range(taxels):
        usable = False
        for f in range(families):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                t = (planes[f, 0, n] / depth) ** 2 + (planes[f, 1, n] / depth) ** 2
                by = math.sqrt((t + 4) / (t + 1)) if strain else 1.0
                signal[f, n] = abs(planes[f, 2, n]) * by / (t + 1) ** 2
                peak[n] = max(peak[n], signal[f, n])
                usable = True
        if usable:
            k, own = count, peak[n] * trust[n]
            if k >= VOTERS and own > peak[order[VOTERS - 1]] * trust[order[VOTERS - 1]]:
                order[k] = order[VOTERS - 1]
                k = VOTERS - 1
            if k < VOTERS:
                while k > 0 and own > peak[order[k - 1]] * trust[order[k - 1]]:
                    order[k] = order[k - 1]
                    k -= 1
            order[k] = n
            count += 1
    return signal, peak, order[:count]


@njit(inline="always")
def _nearest(place, i, x, y):  # type: ignore[no-untyped-def]
    """Return which candidate (families, taxels, 2) of taxel i is nearest to (x, y), and the squared distance."""
    chosen, nearest = 0, np.inf
    for f in range(len(place)):
        far = (place[f, i, 0] - x) ** 2 + (place[f, i, 1] - y) ** 2
        if far < nearest:
            chosen, nearest = f, far
    return chosen, nearest


@kept_helper(error_model="numpy")
def _candidates(at, planes, order, depth):  # type: ignore[no-untyped-def]
    """Return the places (families, taxels, 2) of the taxels' answers, infinite where there is none."""
    place = np.full((len(planes), order.size, 2), np.inf)
    for i in range(order.size):
        n = order[i]
        for f in range(len(planes)):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                place[f, i, 0] = (planes[f, 0, n] + at[n, 0] - at[order[0], 0]) / depth
                place[f, i, 1] = (planes[f, 1, n] + at[n, 1] - at[order[0], 1]) / depth
    return place


@kept_njit(error_model="numpy")
def consensus(at, planes, signal, trust, order, depth):  # type: ignore[no-untyped-def]
    """Return places (k, 3) as x, y and scatter: the means of the taxels' answers nearest to an answer of a seed.

    A candidate at t = rho^2 / z^2 weighs (signal / (1 + t))^2: the inverse variance of its place for equal noise.
    Answers farther away than a depth are not averaged and scatter by one depth: one false taxel cannot shift the mean.
    """
    families, taxels = signal.shape[0], order.size
    place, weight = _candidates(at, planes, order, depth), np.zeros((families, taxels))
    top = signal[:, order[0]].max()  # squares of very small and very large signals would be 0 and infinite
    for i in range(taxels):
        n = order[i]
        for f in range(families):
            if place[f, i, 0] < np.inf:
                dx, dy = planes[f, 0, n] / depth, planes[f, 1, n] / depth
                weight[f, i] = (trust[n] * signal[f, n] / top / (1 + dx * dx + dy * dy)) ** 2
    tried = np.full((SEEDS * families, 3), np.inf)
    for k in range(min(SEEDS, taxels) * families):
        x0, y0 = place[k % families, k // families, 0], place[k % families, k // families, 1]
        if not x0 < np.inf:
            continue
        total = sum_x = sum_y = scatter = 0.0
        for i in range(taxels):
            chosen, nearest = _nearest(place, i, x0, y0)
            if nearest <= 1:
                total += weight[chosen, i]
                sum_x += weight[chosen, i] * place[chosen, i, 0]
                sum_y += weight[chosen, i] * place[chosen, i, 1]
        x, y = sum_x / total, sum_y / total
        for i in range(taxels):
            chosen, nearest = _nearest(place, i, x, y)
            scatter += weight[chosen, i] * min(nearest, 1.0)
        tried[k, 0], tried[k, 1], tried[k, 2] = x, y, scatter
    return tried


@kept_helper(error_model="numpy")
def two_best(places):  # type: ignore[no-untyped-def]
    """Return the numbers of the place (x, y, cost) of least cost and of the next one apart from it, else the same."""
    first = 0
    for k in range(1, len(places)):
        if places[k, 2] < places[first, 2]:
            first = k
    second = first
    for k in range(len(places)):
        apart = (places[k, 0] - places[first, 0]) ** 2 + (places[k, 1] - places[first, 1]) ** 2 > SAME * SAME
        if places[k, 2] < np.inf and apart and (second == first or places[k, 2] < places[second, 2]):
            second = k
    return first, second


@kept_njit(error_model="numpy")
def signals(at, planes, scale, order, place, depth, strain, top):  # type: ignore[no-untyped-def]
    """Return the places (n, 2), the signals (n, 3) over ``top`` times their ``scale`` (n, 3), and the ``tie`` (3,).

    The signals are those of the answer nearest to ``place``. Taxels on a line do not measure shear across it, one taxel
    none: ``tie`` has the coefficients of Q^2, Q R and R^2 that keep it at zero.
    """
    taxels = order.size
    seen, measured, tie, scaled = np.empty((taxels, 2)), np.empty((taxels, 3)), np.zeros(3), np.empty((taxels, 3))
    place_of = _candidates(at, planes, order, depth)
    xx = xy = yy = 0.0
    for i in range(taxels):
        n = order[i]
        seen[i, 0] = (at[n, 0] - at[order[0], 0]) / depth
        seen[i, 1] = (at[n, 1] - at[order[0], 1]) / depth
        chosen, _ = _nearest(place_of, i, place[0], place[1])
        x, y = -planes[chosen, 0, n] / depth, -planes[chosen, 1, n] / depth
        near = 1 / (1 + x * x + y * y)
        g = near * near * math.sqrt(near) * (planes[chosen, 2, n] / top)
        if strain:
            measured[i, 0], measured[i, 1], measured[i, 2] = -3 * x * g, -3 * y * g, (x * x + y * y - 2) * g
        else:
            measured[i, 0], measured[i, 1], measured[i, 2] = -x * g, -y * g, -g
        for k in range(3):
            scaled[i, k] = scale[n, k]
            measured[i, k] *= scaled[i, k]
        xx += seen[i, 0] * seen[i, 0]
        xy += seen[i, 0] * seen[i, 1]
        yy += seen[i, 1] * seen[i, 1]
    if xx + yy == 0:
        tie[0], tie[2] = UNOBSERVABLE, UNOBSERVABLE
    elif xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2:
        if min(xx, yy) <= STRAIGHT * STRAIGHT * (xx + yy):
            xx, xy, yy = (xx, 0.0, 0.0) if yy < xx else (0.0, 0.0, yy)
        tie[0], tie[1], tie[2] = yy, -xy, xx
        for k in range(3):
            tie[k] *= UNOBSERVABLE / (xx + yy)
    return seen, measured, scaled, tie


@kept_njit(error_model="numpy")
def residuals_of_places(data, tried):  # type: ignore[no-untyped-def]
    """Replace the scatter of places (x, y, scatter) by chi^2 of the best load: noise agrees on some place, too."""
    load = np.zeros((1, 5))
    for k in range(len(tried)):
        if tried[k, 2] < np.inf:
            tried[k, 2] = _chi(data, tried[k], load)


@kept_njit(error_model="numpy")
def layer_places(data, tried, noise):  # type: ignore[no-untyped-def]
    """Return places (x, y, chi^2) from which a load on a layer may be fitted: of ``tried`` (k, 3), or of a square too.

    The half-space's answers ``tried`` agree on a wrong place where the cover is thin.
    """
    seen, measured, scale, strain, layer, tie = data
    load, taxels = np.zeros((1, 5)), len(seen)
    first, _ = two_best(tried)
    _chi(data, tried[first], load)
    chi, _ = least_squares(data, load, STEPS)
    free = max(measured.size - 5.0, 1.0)
    if chi <= max(GOOD, noise) ** 2 * (free + CHANCE * math.sqrt(2 * free)) and taxels >= FEWEST:
        tried[first, 0], tried[first, 1], tried[first, 2] = load[0, 0], load[0, 1], chi
        return tried
    few = min(taxels, TAXELS)
    some = seen[:few], measured[:few], scale[:few], strain, layer, tie
    places = np.full((len(tried) + SIDE * SIDE, 3), np.inf)
    for k in range(len(places)):
        if k < len(tried):
            places[k, 0], places[k, 1], places[k, 2] = tried[k, 0], tried[k, 1], tried[k, 2]
        else:
            j = k - len(tried)
            places[k, 0] = HALF * (2 * (j % SIDE) / (SIDE - 1.0) - 1)
            places[k, 1] = HALF * (2 * (j // SIDE) / (SIDE - 1.0) - 1)
            places[k, 2] = _chi(some, places[k], load)
    # the valleys of fewer signals are long
    taken, steps = (TAKEN, STEPS) if taxels >= FEWEST else (SIDE * SIDE, 10 * STEPS)
    starts = np.full((len(tried) + taken, 3), np.inf)
    for k in range(len(starts)):
        best = k
        if k >= len(tried):
            best, _ = two_best(places[len(tried) :])
            best += len(tried)
        if places[best, 2] < np.inf:
            _chi(some, places[best], load)
            places[best, 2] = np.inf
            starts[k, 2], _ = least_squares(some, load, steps)
            starts[k, 0], starts[k, 1] = load[0, 0], load[0, 1]
            if few < taxels:
                starts[k, 2] = _chi(data, starts[k], load)
    return starts


@kept_helper(error_model="numpy")
def _chi(data, place, load):  # type: ignore[no-untyped-def]
    """Set the load (1, 5) to the best one at a place and return its chi^2."""
    load[0, 0], load[0, 1] = place[0], place[1]
    return forces(data, load[0])
