"""Least-squares fit of point loads to the signals of all taxels, compiled: Gauss-Newton steps with Levenberg's damping.

TaxelSignals and lengths as in `field_numba`. Source: D. W. Marquardt, J. SIAM 11 (1963) 431.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.field_numba import dot, energy, equations, jacobian, residual
from tactile.inverse.limits import (
    ALL_TAXELS,
    CHANCE,
    CONVERGED,
    DAMPING,
    FOREIGN_RATIO,
    FOREIGN_SHARE,
    FOREIGN_SIGMAS,
    NOISE_ERROR,
    NOISE_FROM,
    NOT_CHANCE,
    REACH,
    ROUNDING,
    STEPS,
    STIFF,
)


@kept_helper(error_model="numpy")
def invert(matrix, damping, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Fill ``out`` with the inverse of a symmetric matrix, its diagonal times 1 + damping; False if not definite."""
    size = len(matrix)
    for i in range(size):
        for j in range(size):
            out[i, j] = matrix[i, j]
        out[i, i] *= 1 + damping
    for k in range(size):
        pivot = out[k, k]
        if not pivot > 1e-14 * matrix[k, k]:
            return False
        out[k, k] = 1.0
        for j in range(size):
            out[k, j] /= pivot
        for i in range(size):
            if i != k:
                factor = out[i, k]
                out[i, k] = 0.0
                for j in range(size):
                    out[i, j] -= factor * out[k, j]
    return True


@kept_helper(error_model="numpy")
def least_squares(data, loads, steps):  # type: ignore[no-untyped-def]
    """Improve the loads (k, 5) in place; return chi^2 and the covariance (5 k, 5 k) for signals of variance 1.

    The covariance is infinite where the normal matrix is singular. ``data``: places (n, 2), signals (n, 3), their
    scale (n, 3), whether they are strains, table of the layer, and ``tie`` (3,) as `equations` has it.
    """
    at, measured, scale, strain, layer, tie = data
    size = 5 * len(loads)
    matrix, vector, inverse = np.empty((size, size)), np.empty(size), np.empty((size, size))
    next_matrix, next_vector, tried = np.empty((size, size)), np.empty(size), np.empty(loads.shape)
    chi, whole, damping = (
        equations(at, measured, scale, loads, strain, layer, tie, matrix, vector),
        energy(measured),
        0.0,
    )
    for _ in range(steps):
        if chi <= ROUNDING * whole or damping > STIFF:
            break
        if not invert(matrix, damping, inverse):
            damping = max(10 * damping, DAMPING)
            continue
        for k in range(size):
            tried[k // 5, k % 5] = loads[k // 5, k % 5] + dot(inverse[k], vector)
        then = equations(at, measured, scale, tried, strain, layer, tie, next_matrix, next_vector)
        if not then < chi:
            damping = max(10 * damping, DAMPING)
            continue
        less, chi = chi - then, then
        for k in range(size):  # an assignment of arrays takes seconds to compile
            loads[k // 5, k % 5] = tried[k // 5, k % 5]
        matrix, next_matrix = next_matrix, matrix
        vector, next_vector = next_vector, vector
        damping = damping / 10 if damping > DAMPING else 0.0
        if less * (3 * len(at) - size) <= CONVERGED * chi:
            break
    if not invert(matrix, 0.0, inverse):
        inverse[:] = np.inf
    return chi, inverse


@kept_helper(error_model="numpy")
def forces(data, load):  # type: ignore[no-untyped-def]
    """Fill in (Q, R, F) of a load at a given place by linear least squares; return chi^2. Three taxels: eq. (14)."""
    at, measured, scale, strain, layer, tie = data
    out, left = np.empty((5, 3, len(at))), measured.T.copy()
    load[2] = load[3] = load[4] = 0.0
    jacobian(at, scale, load, strain, layer, left, out)
    table, signals = out.reshape((5, measured.size)), left.reshape(measured.size)
    matrix, inverse, vector = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for m in range(3):
        vector[m] = dot(table[2 + m], signals)
        for n in range(3):
            matrix[m, n] = dot(table[2 + m], table[2 + n])
    matrix[0, 0] += tie[0]
    matrix[1, 0] += tie[1]
    matrix[0, 1] += tie[1]
    matrix[1, 1] += tie[2]
    if not invert(matrix, 0.0, inverse):
        return np.inf
    chi = dot(signals, signals)
    for m in range(3):
        load[2 + m] = dot(inverse[m], vector)
        chi -= load[2 + m] * vector[m]
    return max(chi, 0.0)


@kept_helper(error_model="numpy")
def _near(at, measured, scale, loads):  # type: ignore[no-untyped-def]
    """Return the taxels to fit: of more than `ALL_TAXELS` those within `REACH` of a load, if enough are."""
    use, count = np.empty(len(at), np.int64), 0
    for i in range(len(at)):
        for k in range(len(loads)):
            if (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2 < REACH * REACH:
                use[count] = i
                count += 1
                break
    if len(at) <= ALL_TAXELS or count < NOISE_FROM * len(loads):
        return at, measured, scale
    some, part, weight = np.empty((count, 2)), np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        some[i, 0], some[i, 1] = at[use[i], 0], at[use[i], 1]
        for m in range(3):
            part[i, m], weight[i, m] = measured[use[i], m], scale[use[i], m]
    return some, part, weight


@kept_njit(error_model="numpy")
def fit(data, loads, noise, place_only):  # type: ignore[no-untyped-def]
    """Fit the loads (k, 5) in place, one of which only the place is given if ``place_only``.

    Return chi^2, that without any load, the covariance (5 k, 5 k) for signals of variance 1, the residuals (n, 3), and
    the taxel out of `REACH` with the largest residual, -1 for none.
    """
    at, measured, scale, strain, layer, tie = data
    near, part, weight = _near(at, measured, scale, loads)
    some = near, part, weight, strain, layer, tie
    if place_only:
        forces(some, loads[0])
    chi, covariance = least_squares(some, loads, STEPS)
    left = residual(at, measured, scale, loads, strain, layer)
    if len(near) < len(at):
        chi = energy(left)
    return chi, energy(measured), covariance, left, _foreign(at, left, measured, loads, noise)


@kept_helper(error_model="numpy")
def _foreign(at, left, measured, loads, noise):  # type: ignore[no-untyped-def]
    worst, least = -1, max(FOREIGN_SHARE, FOREIGN_SIGMAS * noise)
    largest = least * least
    for i in range(len(left)):
        size = made = 0.0
        for k in range(3):
            size += left[i, k] ** 2
            made += (measured[i, k] - left[i, k]) ** 2
        if size > largest and size > FOREIGN_RATIO * FOREIGN_RATIO * made:
            nearest = np.inf
            for k in range(len(loads)):
                nearest = min(nearest, (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2)
            if nearest > REACH * REACH:
                worst, largest = i, size
    return worst


@kept_njit(error_model="numpy")
def misfits(chi, whole, taxels, free, noise, estimate):  # type: ignore[no-untyped-def]
    """Return the part of chi^2 that noise may explain, the part that is surely no noise, and the misfit.

    ``noise``: 0 where it is unknown; ``estimate`` is the first part then. The misfit is the share of the signals, as
    root mean squares, that neither the loads nor noise explain.
    """
    random, excess = estimate, max(chi - estimate, 0.0) if estimate > 0 else 0.0
    if noise > 0:
        random = noise * noise * (free * (1 + 2 * NOISE_ERROR) + CHANCE * math.sqrt(2.0 * free))
        excess = max(chi - noise * noise * (free + NOT_CHANCE * math.sqrt(2.0 * free)), 0.0)
    signal = max(whole - random, random / taxels)
    misfit = math.sqrt(min(max(chi - random, 0.0) / signal, 1.0)) if signal > 0 else 0.0
    return random, excess, misfit


@kept_njit(error_model="numpy")
def student(free):  # type: ignore[no-untyped-def]
    """Return Student's 68 % quantile, 1 + 1 / (2 n) + 1 / (4 n^2) + 0.09 / n^4 to 0.3 %; 1 for no degree of freedom."""
    t = 1.0 / free if free >= 1 else 0.0
    return 1.0 + t * (0.5 + t * (0.25 + t * t * 0.09))
