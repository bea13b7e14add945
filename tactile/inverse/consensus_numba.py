"""Where the taxels' own answers agree, compiled: the start of `tactile.inverse.localise.localise`.

Lengths are in depths, seen from the strongest taxel; ``planes`` (families, 4, taxels) as the inverse gives them.
"""

import math

import numpy as np
from numba import njit

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.fit import TIED
from tactile.inverse.validity import Validity

INSIDE, OUTSIDE = float(Validity.INSIDE), float(Validity.OUTSIDE)
STRAIGHT = 1e-5
"""A line of taxels that leans so little off an axis lies on it: the shear along it is known, but for so much of that
across."""


@kept_helper(error_model="numpy")
def gain(t, strain):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return the size of the signal for s / z = 1 at rho^2 / z^2 = t from the load, up to a constant: eqs (1), (10)."""
    if strain:
        return math.sqrt((t + 1) * (t + 4)) / ((t + 1) ** 2 * math.sqrt(t + 1))
    return 1 / (t + 1) ** 2


@kept_njit(error_model="numpy")
def strongest(planes, trust, depth, strain, first):  # type: ignore[no-untyped-def]
    """Return the signals (families, taxels), 0 where there is none, each taxel's largest, and the taxels that have one.

    The ``first`` strongest of them, by signal times ``trust``, come first and in order: they alone are asked for it,
    and numba needs a second to compile a sort.
    """
    families, _, taxels = planes.shape
    signal, peak, count = np.zeros((families, taxels)), np.zeros(taxels), 0
    use = np.empty(taxels, np.int64)
    for n in range(taxels):
        usable = False
        for f in range(families):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                t = (planes[f, 0, n] / depth) ** 2 + (planes[f, 1, n] / depth) ** 2
                signal[f, n] = abs(planes[f, 2, n]) * gain(t, strain)
                peak[n] = max(peak[n], signal[f, n])
                usable = True
        if usable:
            k, own = count, peak[n] * trust[n]
            if k >= first and own > peak[use[first - 1]] * trust[use[first - 1]]:
                use[k] = use[first - 1]
                k = first - 1
            if k < first:
                while k > 0 and own > peak[use[k - 1]] * trust[use[k - 1]]:
                    use[k] = use[k - 1]
                    k -= 1
            use[k] = n
            count += 1
    return signal, peak, use[:count]


@njit(inline="always")
def _nearest(place, i, x, y):  # type: ignore[no-untyped-def]
    """Return which of the candidates (families, taxels, 2) of taxel i is nearest to (x, y), and how far squared."""
    chosen, nearest = 0, np.inf
    for f in range(len(place)):
        far = (place[f, i, 0] - x) ** 2 + (place[f, i, 1] - y) ** 2
        if far < nearest:
            chosen, nearest = f, far
    return chosen, nearest


@kept_helper(error_model="numpy")
def candidates(at, planes, order, depth):  # type: ignore[no-untyped-def]
    """Return the places (families, taxels, 2) that the taxels' answers name, infinite where there is none."""
    place = np.full((len(planes), order.size, 2), np.inf)
    for i in range(order.size):
        n = order[i]
        for f in range(len(planes)):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                place[f, i, 0] = (planes[f, 0, n] + at[n, 0] - at[order[0], 0]) / depth
                place[f, i, 1] = (planes[f, 1, n] + at[n, 1] - at[order[0], 1]) / depth
    return place


@kept_njit(error_model="numpy")
def consensus(at, planes, signal, trust, order, depth, seeds):  # type: ignore[no-untyped-def]
    """Return the places (x, y) that were tried with their scatter, which is best, and which is next best.

    Every candidate of the first ``seeds`` taxels is tried: each taxel's candidate nearest to it, and the weighted mean
    of those within a depth. Answers farther away count as one depth, so that one false taxel cannot pull the place.
    """
    families, taxels = signal.shape[0], order.size
    place, weight = candidates(at, planes, order, depth), np.zeros((families, taxels))
    top = signal[:, order[0]].max()  # squares of very small and very large signals would be 0 and infinite
    for i in range(taxels):
        n = order[i]
        for f in range(families):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                dx, dy = planes[f, 0, n] / depth, planes[f, 1, n] / depth
                weight[f, i] = (trust[n] * signal[f, n] / top / (1 + dx * dx + dy * dy)) ** 2
    tried = np.full((seeds * families, 3), np.inf)
    best = -1
    for seed in range(min(seeds, taxels)):
        for family in range(families):
            k = seed * families + family
            x0, y0 = place[family, seed, 0], place[family, seed, 1]
            if not x0 < np.inf:
                continue
            total = sum_x = sum_y = 0.0
            for i in range(taxels):
                chosen, nearest = _nearest(place, i, x0, y0)
                if nearest <= 1:
                    w = weight[chosen, i]
                    total += w
                    sum_x += w * place[chosen, i, 0]
                    sum_y += w * place[chosen, i, 1]
            x, y, scatter = sum_x / total, sum_y / total, 0.0
            for i in range(taxels):
                chosen, nearest = _nearest(place, i, x, y)
                scatter += weight[chosen, i] * min(nearest, 1.0)
            # one by one: to assign a tuple to a row takes numba two seconds to compile
            tried[k, 0], tried[k, 1], tried[k, 2] = x, y, scatter
            if best < 0 or scatter < tried[best, 2]:
                best = k
    rival = best
    for k in range(len(tried)):
        apart = (tried[k, 0] - tried[best, 0]) ** 2 + (tried[k, 1] - tried[best, 1]) ** 2 > 0.01
        if tried[k, 0] < np.inf and apart and (rival == best or tried[k, 2] < tried[rival, 2]):
            rival = k
    return tried, best, rival


@kept_njit(error_model="numpy")
def signals(at, planes, scale, order, place, depth, strain, top):  # type: ignore[no-untyped-def]
    """Return the places (n, 2) of the taxels, their signals (n, 3), what they are scaled by, what holds shear at zero.

    The signals are those of the answer nearest to ``place``, over ``top``, times ``scale`` (taxels, 3).
    Taxels on a line cannot tell shear across it, one taxel none at all: the last (3,) is the part for
    (Q Q, Q R, R R) of a matrix that then makes it zero.
    """
    taxels = order.size
    seen, felt, tie, scaled = np.empty((taxels, 2)), np.empty((taxels, 3)), np.zeros(3), np.empty((taxels, 3))
    answers = candidates(at, planes, order, depth)
    for i in range(taxels):
        n = order[i]
        seen[i, 0] = (at[n, 0] - at[order[0], 0]) / depth
        seen[i, 1] = (at[n, 1] - at[order[0], 1]) / depth
        chosen, _ = _nearest(answers, i, place[0], place[1])
        x, y = -planes[chosen, 0, n] / depth, -planes[chosen, 1, n] / depth
        near = 1 / (1 + x * x + y * y)
        g = near * near * math.sqrt(near) * (planes[chosen, 2, n] / top)
        if strain:
            felt[i, 0], felt[i, 1], felt[i, 2] = -3 * x * g, -3 * y * g, (x * x + y * y - 2) * g
        else:
            felt[i, 0], felt[i, 1], felt[i, 2] = -x * g, -y * g, -g
        for k in range(3):
            scaled[i, k] = scale[n, k]
            felt[i, k] *= scaled[i, k]
    xx = xy = yy = 0.0
    for i in range(taxels):
        xx += seen[i, 0] * seen[i, 0]
        xy += seen[i, 0] * seen[i, 1]
        yy += seen[i, 1] * seen[i, 1]
    if xx + yy == 0:
        tie[0], tie[2] = TIED, TIED
    elif xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2:
        if min(xx, yy) <= STRAIGHT * STRAIGHT * (xx + yy):
            xx, xy, yy = (xx, 0.0, 0.0) if yy < xx else (0.0, 0.0, yy)
        tie[0], tie[1], tie[2] = TIED * yy / (xx + yy), -TIED * xy / (xx + yy), TIED * xx / (xx + yy)
    return seen, felt, scaled, tie
