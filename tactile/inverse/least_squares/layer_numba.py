"""Signals of point loads on a bonded layer with their slopes, compiled: from the polynomials of `layer_field`.

Lengths are in depths, signals in newtons, as in `half_space_numba`; the field's formula stands in `tactile.elastic`.
"""

import math

from numba import njit

from cnnsim.support.compiled_loops import kept_helper
from tactile.inverse.least_squares.half_space_numba import LOOSELY


@njit(inline="always")
def _value(cubic, f, u):  # type: ignore[no-untyped-def]  # numba types it at the call
    return cubic[f, 0] + u * (cubic[f, 1] + u * (cubic[f, 2] + u * cubic[f, 3]))


@njit(inline="always")
def _slope(cubic, f, u):  # type: ignore[no-untyped-def]
    return cubic[f, 1] + u * (2 * cubic[f, 2] + u * (3 * cubic[f, 3]))


@njit(inline="always")
def _field(layer, x, y):  # type: ignore[no-untyped-def]
    """Return N, M, S, O and E at a taxel (x, y) from a load, with the polynomials, where on them, and 1 / r."""
    near = 1 / math.sqrt(1 + x * x + y * y)
    along = near * len(layer)
    i = min(int(along), len(layer) - 1)
    cubic, u = layer[i], along - i
    values = _value(cubic, 0, u), _value(cubic, 1, u), _value(cubic, 2, u), _value(cubic, 3, u), _value(cubic, 4, u)
    return values, cubic, u, near


@njit(inline="always")
def _slopes(layer, x, y, q, r, f, a, b, c):  # type: ignore[no-untyped-def]
    """Return six times three numbers: the signals of a load at a taxel (x, y) from it, and slopes along its numbers."""
    (n, m, s, o, e), cubic, u, near = _field(layer, x, y)
    of = -near * near * near * len(layer)  # d near / d x is that times x
    n_x, m_x, s_x = of * _slope(cubic, 0, u), of * _slope(cubic, 1, u), of * _slope(cubic, 2, u)
    o_x, e_x = of * _slope(cubic, 3, u), of * _slope(cubic, 4, u)
    drag = q * x + r * y
    size, by_e = f * s + drag * o, f * s_x + drag * o_x
    by_x, by_y, fall = x * by_e + q * o, y * by_e + r * o, drag * m_x - f * n_x
    return (
        (a * (q * e - x * size), b * (r * e - y * size), c * (f * n - drag * m)),
        (a * (size + x * by_x - q * x * e_x), b * (y * by_x - r * x * e_x), c * (q * m + x * fall)),
        (a * (x * by_y - q * y * e_x), b * (size + y * by_y - r * y * e_x), c * (r * m + y * fall)),
        (a * (e - x * x * o), -b * x * y * o, -c * x * m),
        (-a * x * y * o, b * (e - y * y * o), -c * y * m),
        (-a * x * s, -b * y * s, c * n),
    )


@njit(inline="always")
def _dot(one, other):  # type: ignore[no-untyped-def]
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def layer_slopes(at, scale, load, layer, rest, out):  # type: ignore[no-untyped-def]
    """Take a load's signals from ``rest`` (3, n) and fill ``out`` (5, 3, n): their slopes along its five numbers."""
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    for i in range(len(at)):
        made, x, y, by_q, by_r, by_f = _slopes(
            layer, at[i, 0] - x0, at[i, 1] - y0, q, r, f, scale[i, 0], scale[i, 1], scale[i, 2]
        )
        for j in range(3):
            rest[j, i] -= made[j]
            out[0, j, i], out[1, j, i], out[2, j, i], out[3, j, i], out[4, j, i] = (
                x[j], y[j], by_q[j], by_r[j], by_f[j],
            )  # fmt: skip


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def layer_sums(at, felt, scale, load, layer):  # type: ignore[no-untyped-def]
    """Return chi^2 of one load and the sums of its normal equations: numbers of their own, which stay in registers."""
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    chi = xx = xy = yy = xq = xr = xf = yq = yr = yf = qq = qr = rr = qf = rf = ff = 0.0
    vx = vy = vq = vr = vf = 0.0
    for i in range(len(at)):
        made, x, y, by_q, by_r, by_f = _slopes(
            layer, at[i, 0] - x0, at[i, 1] - y0, q, r, f, scale[i, 0], scale[i, 1], scale[i, 2]
        )
        left = felt[i, 0] - made[0], felt[i, 1] - made[1], felt[i, 2] - made[2]
        chi += _dot(left, left)
        xx += _dot(x, x)
        xy += _dot(x, y)
        yy += _dot(y, y)
        xq += _dot(x, by_q)
        xr += _dot(x, by_r)
        xf += _dot(x, by_f)
        yq += _dot(y, by_q)
        yr += _dot(y, by_r)
        yf += _dot(y, by_f)
        qq += _dot(by_q, by_q)
        qr += _dot(by_q, by_r)
        rr += _dot(by_r, by_r)
        qf += _dot(by_q, by_f)
        rf += _dot(by_r, by_f)
        ff += _dot(by_f, by_f)
        vx += _dot(left, x)
        vy += _dot(left, y)
        vq += _dot(left, by_q)
        vr += _dot(left, by_r)
        vf += _dot(left, by_f)
    return chi, (xx, xy, yy, xq, yq, qq, xr, yr, qr, rr, xf, yf, qf, rf, ff), (vx, vy, vq, vr, vf)


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def layer_rest(at, felt, scale, loads, layer):  # type: ignore[no-untyped-def]
    """Return the signals (n, 3) that the loads do not explain."""
    left = felt.copy()
    for i in range(len(at)):
        for k in range(len(loads)):
            x, y, q, r, f = at[i, 0] - loads[k, 0], at[i, 1] - loads[k, 1], loads[k, 2], loads[k, 3], loads[k, 4]
            (n, m, s, o, e), _, _, _ = _field(layer, x, y)
            drag = q * x + r * y
            size = f * s + drag * o
            left[i, 0] -= scale[i, 0] * (q * e - x * size)
            left[i, 1] -= scale[i, 1] * (r * e - y * size)
            left[i, 2] -= scale[i, 2] * (f * n - drag * m)
    return left


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def layer_forces(at, felt, scale, place, layer, matrix, vector):  # type: ignore[no-untyped-def]
    """Fill the normal equations (3, 3) of the forces of a load at a place and return chi^2 of no load."""
    chi = qq = qr = rr = qf = rf = ff = vq = vr = vf = 0.0
    for i in range(len(at)):
        x, y, a, b, c = at[i, 0] - place[0], at[i, 1] - place[1], scale[i, 0], scale[i, 1], scale[i, 2]
        (n, m, s, o, e), _, _, _ = _field(layer, x, y)
        by_q = a * (e - x * x * o), -b * x * y * o, -c * x * m
        by_r = -a * x * y * o, b * (e - y * y * o), -c * y * m
        by_f = -a * x * s, -b * y * s, c * n
        one = felt[i, 0], felt[i, 1], felt[i, 2]
        chi += _dot(one, one)
        qq += _dot(by_q, by_q)
        qr += _dot(by_q, by_r)
        rr += _dot(by_r, by_r)
        qf += _dot(by_q, by_f)
        rf += _dot(by_r, by_f)
        ff += _dot(by_f, by_f)
        vq += _dot(one, by_q)
        vr += _dot(one, by_r)
        vf += _dot(one, by_f)
    matrix[0, 0], matrix[1, 0], matrix[1, 1] = qq, qr, rr
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = qf, rf, ff
    vector[0], vector[1], vector[2] = vq, vr, vf
    return chi
