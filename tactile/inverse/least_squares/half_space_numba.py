"""Signals of point loads on an elastic half-space with their slopes, compiled.

Lengths are in depths, signals in newtons: u = (-3 x, -3 y, t - 2) g s of a strain taxel at (x, y) from the load,
(-x, -y, -1) g s of a stress taxel, with g = (1 + t)^(-5/2), t = x^2 + y^2 and s = Q x + R y + F: eqs (1) and (10).
"""

import math

from numba import njit

from cnnsim.support.compiled_loops import kept_helper

LOOSELY = {"reassoc", "contract", "nsz", "arcp"}


@njit(inline="always")
def _parts(x, y, q, r, f, of_a, of_b, of_c, strain):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return 1 / (1 + t), s, g and V g, scaled: what signals and slopes of a taxel (x, y) from a load are made of."""
    lean = 3.0 if strain else 1.0
    t = x * x + y * y
    near = 1 / (1 + t)
    g = near * near * math.sqrt(near)
    height = t - 2 if strain else -1.0
    return near, q * x + r * y + f, g, -lean * x * g * of_a, -lean * y * g * of_b, height * g * of_c


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def half_space_slopes(at, scale, load, strain, rest, out):  # type: ignore[no-untyped-def]
    """Take a load's signals from ``rest`` (3, n) and fill ``out`` (5, 3, n): their slopes along its five numbers."""
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    lean, bend = (3.0, 2.0) if strain else (1.0, 0.0)
    for i in range(len(at)):
        x, y = at[i, 0] - x0, at[i, 1] - y0
        of_a, of_b, of_c = scale[i, 0], scale[i, 1], scale[i, 2]
        near, s, g, a, b, c = _parts(x, y, q, r, f, of_a, of_b, of_c, strain)
        rest[0, i] -= a * s
        rest[1, i] -= b * s
        rest[2, i] -= c * s
        gs = g * s
        along_x, along_y = 5 * x * near * s - q, 5 * y * near * s - r  # -d(g s) / dx and dy over g
        out[0, 0, i], out[0, 1, i] = a * along_x + lean * gs * of_a, b * along_x
        out[0, 2, i] = c * along_x - bend * x * gs * of_c
        out[1, 0, i], out[1, 1, i] = a * along_y, b * along_y + lean * gs * of_b
        out[1, 2, i] = c * along_y - bend * y * gs * of_c
        out[2, 0, i], out[2, 1, i], out[2, 2, i] = a * x, b * x, c * x
        out[3, 0, i], out[3, 1, i], out[3, 2, i] = a * y, b * y, c * y
        out[4, 0, i], out[4, 1, i], out[4, 2, i] = a, b, c


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def half_space_sums(at, felt, scale, load, strain):  # type: ignore[no-untyped-def]
    """Return chi^2 of one load and the sums of its normal equations, which the compiler takes several taxels at a time.

    Every slope is V g times a number, and along x and y the slope of V beside it; only their products are summed.
    """
    x0, y0, q, r, f = load[0], load[1], load[2], load[3], load[4]
    lean, bend = (3.0, 2.0) if strain else (1.0, 0.0)
    chi = xx = xy = yy = xq = xr = xf = yq = yr = yf = qq = qr = rr = qf = rf = ff = 0.0
    vx = vy = vq = vr = vf = 0.0
    for i in range(len(at)):
        x, y = at[i, 0] - x0, at[i, 1] - y0
        of_a, of_b, of_c = scale[i, 0], scale[i, 1], scale[i, 2]
        near, s, g, a, b, c = _parts(x, y, q, r, f, of_a, of_b, of_c, strain)
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
    return chi, (xx, xy, yy, xq, yq, qq, xr, yr, qr, rr, xf, yf, qf, rf, ff), (vx, vy, vq, vr, vf)


@kept_helper(error_model="numpy")
def half_space_rest(at, felt, scale, loads, strain):  # type: ignore[no-untyped-def]
    """Return the signals (n, 3) that the loads do not explain."""
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
