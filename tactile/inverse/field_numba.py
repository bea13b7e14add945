"""Signals of point loads on an elastic half-space or a bonded layer, and their derivatives, compiled.

Lengths are in depths, signals and forces in newtons. With s = Q x + R y and the taxel at (x, y) from the load,

    zz = F N - s M,   xz = -x (F S + s O) + Q E,   yz = -y (F S + s O) + R E

N, M, S, O and E depend on the distance alone (`tactile.elastic.layer_field`). The half-space has E = 0 and, with
t = x^2 + y^2 and g = (1 + t)^(-5/2), N = -M = (t - 2) g, S = O = 3 g for strain and N = -M = -g, S = O = g for stress:
eqs (1) and (10). An empty ``layer`` table selects the half-space. ``scale`` (n, 3) multiplies every signal.
"""

import math

import numpy as np
from numba import njit

from cnnsim.support.compiled_loops import kept_helper, kept_njit

FAST = {"reassoc", "contract", "nsz", "arcp"}


@njit(inline="always")
def _field(layer, strain, x, y):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return N, M, S, O, E at (x, y), and their derivatives along x over x, which are those along y over y."""
    near = 1 / (1 + x * x + y * y)
    if len(layer) > 0:
        root = math.sqrt(near)
        along = root * len(layer)
        i = min(int(along), len(layer) - 1)
        c, u, by = layer[i], along - i, -near * root * len(layer)
        n, m = _cubic(c, 0, u), _cubic(c, 1, u)
        s, o, e = _cubic(c, 2, u), _cubic(c, 3, u), _cubic(c, 4, u)
        slopes = by * _slope(c, 0, u), by * _slope(c, 1, u), by * _slope(c, 2, u), by * _slope(c, 3, u)
        return n, m, s, o, e, slopes[0], slopes[1], slopes[2], slopes[3], by * _slope(c, 4, u)
    g = near * near * math.sqrt(near)
    h = -5 * near * g
    if strain:
        n, n_x, s, s_x = (1 / near - 3) * g, 2 * g + (1 / near - 3) * h, 3 * g, 3 * h
    else:
        n, n_x, s, s_x = -g, -h, g, h
    return n, -n, s, s, 0.0, n_x, -n_x, s_x, s_x, 0.0


@njit(inline="always")
def _cubic(c, f, u):  # type: ignore[no-untyped-def]
    return c[f, 0] + u * (c[f, 1] + u * (c[f, 2] + u * c[f, 3]))


@njit(inline="always")
def _slope(c, f, u):  # type: ignore[no-untyped-def]
    return c[f, 1] + u * (2 * c[f, 2] + u * (3 * c[f, 3]))


@kept_helper(error_model="numpy", fastmath=FAST)
def jacobian(at, scale, load, strain, layer, rest, out):  # type: ignore[no-untyped-def]
    """Subtract a load's signals from ``rest`` (3, n) and fill ``out`` (5, 3, n) with their derivatives by its numbers.

    Arguments: ``at`` (n, 2) places of the taxels; ``load`` (x, y, Q, R, F); ``layer`` table of `layer_field`.
    """
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    for i in range(len(at)):
        x, y, a, b, c = at[i, 0] - x0, at[i, 1] - y0, scale[i, 0], scale[i, 1], scale[i, 2]
        n, m, s, o, e, n_x, m_x, s_x, o_x, e_x = _field(layer, strain, x, y)
        drag = q * x + r * y
        size, by_e = f * s + drag * o, f * s_x + drag * o_x
        by_x, by_y, fall = x * by_e + q * o, y * by_e + r * o, drag * m_x - f * n_x
        rest[0, i] -= a * (q * e - x * size)
        rest[1, i] -= b * (r * e - y * size)
        rest[2, i] -= c * (f * n - drag * m)
        out[0, 0, i], out[0, 1, i] = a * (size + x * by_x - q * x * e_x), b * (y * by_x - r * x * e_x)
        out[0, 2, i] = c * (q * m + x * fall)
        out[1, 0, i], out[1, 1, i] = a * (x * by_y - q * y * e_x), b * (size + y * by_y - r * y * e_x)
        out[1, 2, i] = c * (r * m + y * fall)
        out[2, 0, i], out[2, 1, i], out[2, 2, i] = a * (e - x * x * o), -b * x * y * o, -c * x * m
        out[3, 0, i], out[3, 1, i], out[3, 2, i] = -a * x * y * o, b * (e - y * y * o), -c * y * m
        out[4, 0, i], out[4, 1, i], out[4, 2, i] = -a * x * s, -b * y * s, c * n


@kept_njit(error_model="numpy", fastmath=FAST)
def residual(at, measured, scale, loads, strain, layer):  # type: ignore[no-untyped-def]
    """Return the signals ``measured`` (n, 3) less those of the loads (k, 5)."""
    left = measured.copy()
    for i in range(len(at)):
        for k in range(len(loads)):
            x, y, q, r, f = at[i, 0] - loads[k, 0], at[i, 1] - loads[k, 1], loads[k, 2], loads[k, 3], loads[k, 4]
            n, m, s, o, e, _, _, _, _, _ = _field(layer, strain, x, y)
            drag = q * x + r * y
            size = f * s + drag * o
            left[i, 0] -= scale[i, 0] * (q * e - x * size)
            left[i, 1] -= scale[i, 1] * (r * e - y * size)
            left[i, 2] -= scale[i, 2] * (f * n - drag * m)
    return left


@kept_helper(error_model="numpy", fastmath=FAST)
def dot(one, other):  # type: ignore[no-untyped-def]
    """Return the scalar product of two vectors."""
    total = 0.0
    for i in range(len(one)):
        total += one[i] * other[i]
    return total


@kept_helper(error_model="numpy")
def energy(signals):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of signals (n, 3)."""
    total = 0.0
    for i in range(len(signals)):
        total += signals[i, 0] ** 2 + signals[i, 1] ** 2 + signals[i, 2] ** 2
    return total


@kept_njit(error_model="numpy")
def equations(at, measured, scale, loads, strain, layer, tie, matrix, vector):  # type: ignore[no-untyped-def]
    """Fill the normal equations at these loads (k, 5) and return chi^2 without the terms of ``tie``.

    ``tie`` (3,): coefficients of Q^2, Q R and R^2 that keep the shear at zero in directions that are not observable.
    """
    out, left = np.empty((5 * len(loads), 3, len(at))), measured.T.copy()
    for k in range(len(loads)):
        jacobian(at, scale, loads[k], strain, layer, left, out[5 * k : 5 * k + 5])
    table, signals = out.reshape((5 * len(loads), measured.size)), left.reshape(measured.size)
    for m in range(len(table)):
        vector[m] = dot(table[m], signals)
        for n in range(m + 1):
            matrix[m, n] = matrix[n, m] = dot(table[m], table[n])
    for k in range(len(loads)):
        j, q, r = 5 * k, loads[k, 2], loads[k, 3]
        matrix[j + 2, j + 2] += tie[0]
        matrix[j + 3, j + 2] += tie[1]
        matrix[j + 2, j + 3] += tie[1]
        matrix[j + 3, j + 3] += tie[2]
        vector[j + 2] -= tie[0] * q + tie[1] * r
        vector[j + 3] -= tie[1] * q + tie[2] * r
    return dot(signals, signals)
