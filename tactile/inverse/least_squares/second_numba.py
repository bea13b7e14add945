"""Whether a second load explains what one leaves, compiled: to first order, where most is left apart from it.

Lengths and signals as in `half_space_numba`.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.least_squares.equations_numba import product, rest, slopes
from tactile.inverse.least_squares.fit_numba import solve


@kept_njit(error_model="numpy")
def second_load(at, felt, scale, load, strain, layer, tie, apart):  # type: ignore[no-untyped-def]
    """Return the taxel beyond ``apart`` of the load where most is left, the force of a load above it, and the part of
    chi^2 that one there and nearly there explains; -1 where there is none.
    """
    left = rest(at, felt, scale, load.reshape((1, 5)), strain, layer)
    worst, most, chi = -1, 0.0, 0.0
    for i in range(len(at)):
        own = left[i, 0] ** 2 + left[i, 1] ** 2 + left[i, 2] ** 2
        chi += own
        if own > most and (at[i, 0] - load[0]) ** 2 + (at[i, 1] - load[1]) ** 2 > apart * apart:
            worst, most = i, own
    if worst < 0 or not chi > 0:
        return -1, 0.0, 0.0
    nothing, trial = np.zeros((3, len(at))), np.zeros(5)
    trial[0], trial[1], trial[4] = at[worst, 0], at[worst, 1], 1.0
    along, of_trial = np.empty((8, 3, len(at))), np.empty((5, 3, len(at)))
    slopes(at, scale, load, strain, layer, nothing, along[:5])
    slopes(at, scale, trial, strain, layer, nothing, of_trial)
    for i in range(len(at)):  # by hand: an assignment of arrays takes seconds to compile
        for k in range(3):
            along[5, k, i], along[6, k, i], along[7, k, i] = of_trial[0, k, i], of_trial[1, k, i], of_trial[4, k, i]
    table, signals = along.reshape((8, felt.size)), left.T.copy().reshape(felt.size)
    matrix, vector, step, factor = np.empty((8, 8)), np.empty(8), np.empty(8), np.empty((8, 8))
    for m in range(8):
        vector[m] = product(table[m], signals)
        for n in range(m + 1):
            matrix[m, n] = product(table[m], table[n])
    matrix[2, 2] += tie[0]
    matrix[3, 2] += tie[1]
    matrix[3, 3] += tie[2]
    if not solve(matrix, vector, 0.0, factor, step):
        return -1, 0.0, 0.0
    explained = 0.0
    for m in range(8):
        explained += vector[m] * step[m]
    return worst, step[7], explained / chi
