"""Least squares of point loads to the signals of all taxels, compiled: Gauss-Newton with Levenberg's damping.

Signals, lengths and ``scale`` as in `equations_numba`.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.equations_numba import equations

ENOUGH = 0.01
"""A step that lessens chi^2 by so many variances of one signal is the last."""
ROUNDING = 1e-26
"""chi^2 over that of the signals: what is left is rounding."""
DAMPING, STIFF = 1e-3, 1e6


@kept_njit(error_model="numpy")
def fit(at, felt, scale, loads, strain, layer, tie, steps):  # type: ignore[no-untyped-def]
    """Improve the loads (k, 5) in place and return chi^2, that of no load, and the diagonal (k, 5) of the covariance.

    The covariance is that for signals of variance 1. ``tie`` (3,): the part of the matrix for (Q Q, Q R, R R) that
    holds shear at zero in the directions that the taxels cannot tell.
    """
    size = 5 * len(loads)
    matrix, vector, step = np.empty((size, size)), np.empty(size), np.empty(size)
    tried_matrix, tried_vector, tried = np.empty((size, size)), np.empty(size), loads.copy()
    factor = np.empty((size, size))
    chi = equations(at, felt, scale, loads, strain, layer, matrix, vector)
    hold(matrix, vector, loads, tie)
    whole = 0.0
    for i in range(len(at)):
        whole += felt[i, 0] ** 2 + felt[i, 1] ** 2 + felt[i, 2] ** 2
    damping = 0.0
    for _ in range(steps):
        if chi <= ROUNDING * whole or damping > STIFF:
            break
        if not solve(matrix, vector, damping, factor, step):
            damping = max(10 * damping, DAMPING)
            continue
        for k in range(len(loads)):
            for j in range(5):
                tried[k, j] = loads[k, j] + step[5 * k + j]
        then = equations(at, felt, scale, tried, strain, layer, tried_matrix, tried_vector)
        hold(tried_matrix, tried_vector, tried, tie)
        if not then < chi:
            damping = max(10 * damping, DAMPING)
            continue
        less, chi = chi - then, then
        for k in range(len(loads)):  # by hand: an assignment of arrays takes seconds to compile
            for j in range(5):
                loads[k, j] = tried[k, j]
        matrix, tried_matrix = tried_matrix, matrix
        vector, tried_vector = tried_vector, vector
        damping = damping / 10 if damping > DAMPING else 0.0
        if less * (3 * len(at) - size) <= ENOUGH * chi:
            break
    spread = np.full((len(loads), 5), np.inf)
    if factored(matrix, 0.0, factor):
        for m in range(size):
            vector[:] = 0.0
            vector[m] = 1.0
            back(factor, vector, step)
            spread[m // 5, m % 5] = step[m]
    return chi, whole, spread


@kept_helper(error_model="numpy")
def hold(matrix, vector, loads, tie):  # type: ignore[no-untyped-def]
    """Add to the normal equations what holds shear at zero where ``tie`` says so."""
    for k in range(len(loads)):
        j, q, r = 5 * k, loads[k, 2], loads[k, 3]
        matrix[j + 2, j + 2] += tie[0]
        matrix[j + 3, j + 2] += tie[1]
        matrix[j + 3, j + 3] += tie[2]
        vector[j + 2] -= tie[0] * q + tie[1] * r
        vector[j + 3] -= tie[1] * q + tie[2] * r


@kept_helper(error_model="numpy")
def solve(matrix, vector, damping, factor, answer):  # type: ignore[no-untyped-def]
    """Solve by Cholesky from the lower triangle, its diagonal times 1 + damping; False where it is not definite."""
    if not factored(matrix, damping, factor):
        return False
    back(factor, vector, answer)
    return True


@kept_helper(error_model="numpy")
def factored(matrix, damping, factor):  # type: ignore[no-untyped-def]
    """Fill in the factor of Cholesky, as `solve` has it, and return whether the matrix is definite."""
    for m in range(len(matrix)):
        for n in range(m + 1):
            total = matrix[m, n] * (1 + damping) if m == n else matrix[m, n]
            own = total
            for k in range(n):
                total -= factor[m, k] * factor[n, k]
            if m > n:
                factor[m, n] = total / factor[n, n]
            elif not total > 1e-14 * own:
                return False
            else:
                factor[m, m] = math.sqrt(total)
    return True


@kept_helper(error_model="numpy")
def back(factor, vector, answer):  # type: ignore[no-untyped-def]
    """Fill in the answer of the equations of which the factor is known."""
    size = len(vector)
    for m in range(size):
        total = vector[m]
        for k in range(m):
            total -= factor[m, k] * answer[k]
        answer[m] = total / factor[m, m]
    for m in range(size - 1, -1, -1):
        total = answer[m]
        for k in range(m + 1, size):
            total -= factor[k, m] * answer[k]
        answer[m] = total / factor[m, m]


@kept_njit(error_model="numpy")
def near(at, felt, scale, loads, reach, most, least):  # type: ignore[no-untyped-def]
    """Return the taxels that a fit asks: of more than ``most`` those nearer than ``reach`` to one of the loads.

    All of them where those are fewer than ``least`` for each load.
    """
    if len(at) <= most:
        return at, felt, scale
    use, count = np.empty(len(at), np.int64), 0
    for i in range(len(at)):
        for k in range(len(loads)):
            if (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2 < reach * reach:
                use[count] = i
                count += 1
                break
    if count < least * len(loads):
        return at, felt, scale
    some, part, weight = np.empty((count, 2)), np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        some[i, 0], some[i, 1] = at[use[i], 0], at[use[i], 1]
        for m in range(3):
            part[i, m], weight[i, m] = felt[use[i], m], scale[use[i], m]
    return some, part, weight
