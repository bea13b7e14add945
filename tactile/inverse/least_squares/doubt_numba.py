"""What speaks against a fit of one point load, compiled: signals far from it, and a reading that is cut off.

Lengths and signals as in `fit_numba`.
"""

import math

import numpy as np

from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.inverse.least_squares.fit_numba import equations, solve
from tactile.inverse.least_squares.layer_numba import layer_slopes


@kept_njit(error_model="numpy")
def foreign(at, left, felt, loads, reach, least, times):  # type: ignore[no-untyped-def]
    """Return the taxel where most is left, of those out of ``reach`` of all loads where it is ``least`` or more and
    ``times`` what is explained; -1 where there is none.
    """
    worst, largest = -1, least * least
    for i in range(len(left)):
        size = made = 0.0
        for k in range(3):
            size += left[i, k] ** 2
            made += (felt[i, k] - left[i, k]) ** 2
        if size > largest and size > times * times * made:
            nearest = np.inf
            for k in range(len(loads)):
                nearest = min(nearest, (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2)
            if nearest > reach * reach:
                worst, largest = i, size
    return worst


@kept_njit(error_model="numpy")
def _slopes_of_one(x, y, load, scale, k, strain, vector):  # type: ignore[no-untyped-def]
    """Return what a load makes at a taxel (x, y) from it, its component k, and fill in the five slopes."""
    near_one = 1 / (1 + x * x + y * y)
    g, s = near_one * near_one * math.sqrt(near_one), load[2] * x + load[3] * y + load[4]
    if k == 0:
        form, along, across = (-3.0 * x if strain else -x), (3.0 if strain else 1.0), 0.0
    elif k == 1:
        form, along, across = (-3.0 * y if strain else -y), 0.0, (3.0 if strain else 1.0)
    elif strain:
        form, along, across = 1 / near_one - 3, -2 * x, -2 * y
    else:
        form, along, across = -1.0, 0.0, 0.0
    of = scale * g
    made = form * of * s
    vector[0] = of * (form * (5 * x * near_one * s - load[2]) + along * s)
    vector[1] = of * (form * (5 * y * near_one * s - load[3]) + across * s)
    vector[2], vector[3], vector[4] = form * of * x, form * of * y, form * of
    return made


@kept_njit(error_model="numpy")
def without_largest(at, felt, scale, load, strain, layer, tie, near):  # type: ignore[no-untyped-def]
    """Return chi^2 without the largest reading and by how many times it would then be larger, and how many are so near.

    To first order: what a reading leaves, r^2, is r^2 / (1 - h) of chi^2, where h = J (J^T J)^-1 J^T of its slopes J.
    """
    worst, k, largest = 0, 0, -1.0
    for i in range(len(at)):
        for m in range(3):
            if scale[i, m] > 0 and abs(felt[i, m]) > largest * scale[i, m]:
                worst, k, largest = i, m, abs(felt[i, m]) / scale[i, m]
    count = 0
    for i in range(len(at)):
        for m in range(3):
            if scale[i, m] > 0 and abs(felt[i, m]) >= largest * scale[i, m] * (1 - near):
                count += 1
    matrix, vector, step, factor = np.empty((5, 5)), np.empty(5), np.empty(5), np.empty((5, 5))
    chi = equations(at, felt, scale, load.reshape((1, 5)), strain, layer, matrix, vector)
    matrix[2, 2] += tie[0]
    matrix[3, 2] += tie[1]
    matrix[3, 3] += tie[2]
    x, y = at[worst, 0] - load[0], at[worst, 1] - load[1]
    if len(layer) > 0:
        slopes = np.empty((6, 3))
        layer_slopes(layer, x, y, load, scale[worst], slopes)
        made = slopes[0, k]
        vector[:] = slopes[1:, k]
    else:
        made = _slopes_of_one(x, y, load, scale[worst, k], k, strain, vector)
    if not solve(matrix, vector, 0.0, factor, step):
        return chi, 1.0, count
    share = 0.0
    for m in range(5):
        share += vector[m] * step[m]
    off = felt[worst, k] - made
    left = max(1 - share, 1e-9)
    return max(chi - off * off / left, 0.0), 1 - off / left / felt[worst, k], count
