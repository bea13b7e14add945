"""Least squares of point loads to the signals of all taxels, compiled: Gauss-Newton with Levenberg's damping.

Lengths are in depths, signals in newtons: u = (-3 x, -3 y, t - 2) g s of a strain taxel at (x, y) from the load,
(-x, -y, -1) g s of a stress taxel, with g = (1 + t)^(-5/2), t = x^2 + y^2 and s = Q x + R y + F: eqs (1) and (10).
Signals come over their standard deviations, and ``scale`` (n, 3) is what they were multiplied by. On a layer of known
thickness, whose table of `layer_field` is not empty, they are those of `layer_numba`.
"""

import math

import numpy as np

from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.inverse.least_squares.layer_numba import layer_equations, layer_rest

ENOUGH = 0.01
"""A step that lessens chi^2 by so many variances of one signal is the last."""
ROUNDING = 1e-26
"""chi^2 over that of the signals: what is left is rounding."""
DAMPING, STIFF = 1e-3, 1e6


@kept_njit(error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})
def equations_of_one(at, felt, scale, load, strain, matrix, vector):  # type: ignore[no-untyped-def]  # numba types it
    """Fill the normal equations of one load and return chi^2: sums that the compiler takes several taxels at a time.

    Every slope is V g times a number, and along x and y the slope of V beside it; only their products are summed.
    """
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    lean, bend = (3.0, 2.0) if strain else (1.0, 0.0)
    chi = xx = xy = yy = xq = xr = xf = yq = yr = yf = qq = qr = rr = qf = rf = ff = 0.0
    vx = vy = vq = vr = vf = 0.0
    for i in range(len(at)):
        x, y = at[i, 0] - x0, at[i, 1] - y0
        t = x * x + y * y
        near = 1 / (1 + t)
        g = near * near * math.sqrt(near)
        s = q * x + r * y + f
        height = t - 2 if strain else -1.0
        of_a, of_b, of_c = scale[i, 0], scale[i, 1], scale[i, 2]
        a, b, c = -lean * x * g * of_a, -lean * y * g * of_b, height * g * of_c
        rest_a, rest_b, rest_c = felt[i, 0] - a * s, felt[i, 1] - b * s, felt[i, 2] - c * s
        chi += rest_a * rest_a + rest_b * rest_b + rest_c * rest_c
        gs = g * s
        grow_x, grow_y = 5 * x * near * s - q, 5 * y * near * s - r
        x_a, x_b, x_c = a * grow_x + lean * gs * of_a, b * grow_x, c * grow_x - bend * x * gs * of_c
        y_a, y_b, y_c = a * grow_y, b * grow_y + lean * gs * of_b, c * grow_y - bend * y * gs * of_c
        own = a * a + b * b + c * c
        of_x, of_y = x_a * a + x_b * b + x_c * c, y_a * a + y_b * b + y_c * c
        left = rest_a * a + rest_b * b + rest_c * c
        xx += x_a * x_a + x_b * x_b + x_c * x_c
        xy += x_a * y_a + x_b * y_b + x_c * y_c
        yy += y_a * y_a + y_b * y_b + y_c * y_c
        xq += of_x * x
        xr += of_x * y
        xf += of_x
        yq += of_y * x
        yr += of_y * y
        yf += of_y
        qq += own * x * x
        qr += own * x * y
        rr += own * y * y
        qf += own * x
        rf += own * y
        ff += own
        vx += rest_a * x_a + rest_b * x_b + rest_c * x_c
        vy += rest_a * y_a + rest_b * y_b + rest_c * y_c
        vq += left * x
        vr += left * y
        vf += left
    matrix[0, 0], matrix[1, 0], matrix[1, 1] = xx, xy, yy
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = xq, yq, qq
    matrix[3, 0], matrix[3, 1], matrix[3, 2], matrix[3, 3] = xr, yr, qr, rr
    matrix[4, 0], matrix[4, 1], matrix[4, 2], matrix[4, 3], matrix[4, 4] = xf, yf, qf, rf, ff
    vector[0], vector[1], vector[2], vector[3], vector[4] = vx, vy, vq, vr, vf
    return chi


@kept_njit(error_model="numpy")
def equations(at, felt, scale, loads, strain, layer, matrix, vector):  # type: ignore[no-untyped-def]
    """Fill the normal equations at these loads and return chi^2."""
    count = len(loads)
    if len(layer) > 0:
        return layer_equations(at, felt, scale, loads, layer, matrix, vector)
    if count == 1:
        return equations_of_one(at, felt, scale, loads[0], strain, matrix, vector)
    slope = np.empty((5 * count, 3))
    matrix[:], vector[:] = 0.0, 0.0
    chi = 0.0
    for i in range(len(at)):
        rest0, rest1, rest2 = felt[i, 0], felt[i, 1], felt[i, 2]
        for k in range(count):
            x, y = at[i, 0] - loads[k, 0], at[i, 1] - loads[k, 1]
            q, r = loads[k, 2], loads[k, 3]
            near = 1 / (1 + x * x + y * y)
            g = near * near * math.sqrt(near)
            s = q * x + r * y + loads[k, 4]
            if strain:
                a, b, c, bend, lean = -3 * x, -3 * y, 1 / near - 3, 2.0, 3.0
            else:
                a, b, c, bend, lean = -x, -y, -1.0, 0.0, 1.0
            a, b, c = a * scale[i, 0], b * scale[i, 1], c * scale[i, 2]
            rest0 -= a * g * s
            rest1 -= b * g * s
            rest2 -= c * g * s
            along_x, along_y = g * (5 * x * near * s - q), g * (5 * y * near * s - r)  # -d(g s) / dx and dy
            j = 5 * k
            slope[j, 0], slope[j, 1], slope[j, 2] = (
                a * along_x + lean * g * s * scale[i, 0],
                b * along_x,
                c * along_x - bend * x * g * s * scale[i, 2],
            )
            slope[j + 1, 0], slope[j + 1, 1] = a * along_y, b * along_y + lean * g * s * scale[i, 1]
            slope[j + 1, 2] = c * along_y - bend * y * g * s * scale[i, 2]
            slope[j + 2, 0], slope[j + 2, 1], slope[j + 2, 2] = a * g * x, b * g * x, c * g * x
            slope[j + 3, 0], slope[j + 3, 1], slope[j + 3, 2] = a * g * y, b * g * y, c * g * y
            slope[j + 4, 0], slope[j + 4, 1], slope[j + 4, 2] = a * g, b * g, c * g
        chi += rest0 * rest0 + rest1 * rest1 + rest2 * rest2
        for m in range(5 * count):
            s0, s1, s2 = slope[m, 0], slope[m, 1], slope[m, 2]
            vector[m] += s0 * rest0 + s1 * rest1 + s2 * rest2
            for n in range(m + 1):
                matrix[m, n] += s0 * slope[n, 0] + s1 * slope[n, 1] + s2 * slope[n, 2]
    return chi


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
        loads[:], matrix[:], vector[:] = tried, tried_matrix, tried_vector
        damping = damping / 10 if damping > DAMPING else 0.0
        if less * (3 * len(at) - size) <= ENOUGH * chi:
            break
    spread = np.full((len(loads), 5), np.inf)
    for m in range(size):
        vector[:] = 0.0
        vector[m] = 1.0
        if solve(matrix, vector, 0.0, factor, step):
            spread[m // 5, m % 5] = step[m]
    return chi, whole, spread


@kept_njit(error_model="numpy")
def hold(matrix, vector, loads, tie):  # type: ignore[no-untyped-def]
    """Add to the normal equations what holds shear at zero where ``tie`` says so."""
    for k in range(len(loads)):
        j, q, r = 5 * k, loads[k, 2], loads[k, 3]
        matrix[j + 2, j + 2] += tie[0]
        matrix[j + 3, j + 2] += tie[1]
        matrix[j + 3, j + 3] += tie[2]
        vector[j + 2] -= tie[0] * q + tie[1] * r
        vector[j + 3] -= tie[1] * q + tie[2] * r


@kept_njit(error_model="numpy")
def solve(matrix, vector, damping, factor, answer):  # type: ignore[no-untyped-def]
    """Solve by Cholesky from the lower triangle, its diagonal times 1 + damping; False where it is not definite."""
    size = len(vector)
    for m in range(size):
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
    return True


@kept_njit(error_model="numpy")
def rest(at, felt, scale, loads, strain, layer):  # type: ignore[no-untyped-def]
    """Return the signals (n, 3) that the loads do not explain."""
    if len(layer) > 0:
        return layer_rest(at, felt, scale, loads, layer)
    left = felt.copy()
    lean = 3.0 if strain else 1.0
    for i in range(len(at)):
        for k in range(len(loads)):
            x, y = at[i, 0] - loads[k, 0], at[i, 1] - loads[k, 1]
            near = 1 / (1 + x * x + y * y)
            gs = near * near * math.sqrt(near) * (loads[k, 2] * x + loads[k, 3] * y + loads[k, 4])
            left[i, 0] += lean * x * gs * scale[i, 0]
            left[i, 1] += lean * y * gs * scale[i, 1]
            left[i, 2] -= ((1 / near - 3) if strain else -1.0) * gs * scale[i, 2]
    return left


@kept_njit(error_model="numpy")
def energy(signals):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of signals (n, 3)."""
    total = 0.0
    for i in range(len(signals)):
        total += signals[i, 0] ** 2 + signals[i, 1] ** 2 + signals[i, 2] ** 2
    return total


@kept_njit(error_model="numpy")
def within(at, loads, reach):  # type: ignore[no-untyped-def]
    """Return which places (n, 2) are nearer than ``reach`` to one of the loads."""
    found, count = np.empty(len(at), np.int64), 0
    for i in range(len(at)):
        for k in range(len(loads)):
            if (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2 < reach * reach:
                found[count] = i
                count += 1
                break
    return found[:count]
