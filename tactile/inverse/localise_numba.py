"""Localisation, compiled: the loops of `tactile.inverse.localise.localise`, which has the formulas.

Lengths are in depths, seen from the strongest taxel; ``planes`` (families, 4, taxels) as the inverse gives them.
"""

import math

import numpy as np
from numba import njit

from tactile.inverse.validity import Validity

INSIDE, OUTSIDE = float(Validity.INSIDE), float(Validity.OUTSIDE)


@njit(cache=True, error_model="numpy")
def shape(x, y, strain):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return t, the unit direction of the signal for s / z = 1 at (x, y) from the load, its size up to a constant.

    Eq. (1) for strain, eq. (10) for stress.
    """
    t = x * x + y * y
    if strain:
        size = math.sqrt((t + 1) * (t + 4))
        return t, -3 * x / size, -3 * y / size, (t - 2) / size, size / ((t + 1) ** 2 * math.sqrt(t + 1))
    size = math.sqrt(t + 1)
    return t, -x / size, -y / size, -1 / size, 1 / (t + 1) ** 2


@njit(cache=True, error_model="numpy")
def strongest(planes, depth, strain):  # type: ignore[no-untyped-def]
    """Return the signals (families, taxels), 0 where there is none, each taxel's largest, and the taxels that have one.

    They are not sorted here: numba needs a second to compile a sort.
    """
    families, _, taxels = planes.shape
    signal, peak, count = np.zeros((families, taxels)), np.zeros(taxels), 0
    use = np.empty(taxels, np.int64)
    for n in range(taxels):
        usable = False
        for f in range(families):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                gain = shape(-planes[f, 0, n] / depth, -planes[f, 1, n] / depth, strain)[4]
                signal[f, n] = abs(planes[f, 2, n]) * gain
                peak[n] = max(peak[n], signal[f, n])
                usable = True
        if usable:
            use[count] = n
            count += 1
    return signal, peak, use[:count]


@njit(cache=True, error_model="numpy")
def consensus(at, planes, signal, order, depth, strain, seeds):  # type: ignore[no-untyped-def]
    """Return the place (x, y), its scatter and weight, the least scatter of another place, the taxels' families.

    Every candidate of the first ``seeds`` taxels is tried: each taxel's candidate nearest to it, and the weighted mean
    of those.
    """
    families, taxels = signal.shape[0], order.size
    place, weight = np.full((families, taxels, 2), np.inf), np.zeros((families, taxels))
    top = signal[:, order[0]].max()  # squares of very small and very large signals would be 0 and infinite
    for i in range(taxels):
        n = order[i]
        for f in range(families):
            if planes[f, 3, n] == INSIDE or planes[f, 3, n] == OUTSIDE:
                dx, dy = planes[f, 0, n] / depth, planes[f, 1, n] / depth
                place[f, i, 0] = dx + (at[n, 0] - at[order[0], 0]) / depth
                place[f, i, 1] = dy + (at[n, 1] - at[order[0], 1]) / depth
                weight[f, i] = (signal[f, n] / top / (1 + dx * dx + dy * dy)) ** 2
    tried = np.full((seeds * families, 4), np.inf)
    chosen = np.zeros((seeds * families, taxels), np.int64)
    best = -1
    for seed in range(min(seeds, taxels)):
        for family in range(families):
            k = seed * families + family
            x0, y0 = place[family, seed, 0], place[family, seed, 1]
            if not x0 < np.inf:
                continue
            total = sum_x = sum_y = 0.0
            for i in range(taxels):
                nearest = np.inf
                for f in range(families):
                    far = (place[f, i, 0] - x0) ** 2 + (place[f, i, 1] - y0) ** 2
                    if far < nearest:
                        nearest, chosen[k, i] = far, f
                w = weight[chosen[k, i], i]
                total += w
                sum_x += w * place[chosen[k, i], i, 0]
                sum_y += w * place[chosen[k, i], i, 1]
            x, y, scatter = sum_x / total, sum_y / total, 0.0
            for i in range(taxels):
                f = chosen[k, i]
                scatter += weight[f, i] * ((place[f, i, 0] - x) ** 2 + (place[f, i, 1] - y) ** 2)
            # one by one: to assign a tuple to a row takes numba two seconds to compile
            tried[k, 0], tried[k, 1], tried[k, 2], tried[k, 3] = x, y, scatter, total
            if best < 0 or scatter < tried[best, 2]:
                best = k
    x, y, scatter, total = tried[best]
    rival = np.inf
    for k in range(len(tried)):
        if tried[k, 0] < np.inf and (tried[k, 0] - x) ** 2 + (tried[k, 1] - y) ** 2 > 0.01:
            rival = min(rival, tried[k, 2])
    return x, y, scatter, total, rival, chosen[best]


@njit(cache=True, error_model="numpy")
def components(at, planes, order, families, place, depth, strain):  # type: ignore[no-untyped-def]
    """Return (Q, R, F) [N] by least squares from the part of every taxel's signal that a load at ``place`` explains."""
    table = np.empty((order.size, 4))
    for i in range(order.size):
        n, f = order[i], families[i]
        x = (at[n, 0] - at[order[0], 0]) / depth - place[0]
        y = (at[n, 1] - at[order[0], 1]) / depth - place[1]
        _, a, b, c, lean = shape(x, y, strain)
        _, own_a, own_b, own_c, gain = shape(-planes[f, 0, n] / depth, -planes[f, 1, n] / depth, strain)
        table[i, 0], table[i, 1], table[i, 2] = x * lean, y * lean, lean
        table[i, 3] = planes[f, 2, n] * gain * (own_a * a + own_b * b + own_c * c)
    return least_squares(table)


@njit(cache=True, error_model="numpy")
def least_squares(table):  # type: ignore[no-untyped-def]
    """Return the three x with table[:, :3] @ x nearest to table[:, 3], by Householder's reflections, in place."""
    for k in range(3):
        norm = 0.0
        for i in range(k, len(table)):
            norm += table[i, k] * table[i, k]
        norm = math.sqrt(norm)
        if table[k, k] > 0:
            norm = -norm
        head = table[k, k] - norm
        for j in range(k + 1, 4):
            along = head * table[k, j]
            for i in range(k + 1, len(table)):
                along += table[i, k] * table[i, j]
            along /= norm * head
            table[k, j] += along * head
            for i in range(k + 1, len(table)):
                table[i, j] += along * table[i, k]
        table[k, k] = norm
    f = table[2, 3] / table[2, 2]
    r = (table[1, 3] - table[1, 2] * f) / table[1, 1]
    q = (table[0, 3] - table[0, 2] * f - table[0, 1] * r) / table[0, 0]
    return q, r, f
