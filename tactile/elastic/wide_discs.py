"""Loads and twists over circles of many depths on the half-space, by spheroidal harmonics: one short series a taxel.

Where the weight of a profile (see ``profiles``) is a sum of c_n P_n(t / a), n even, its potential is

    V = (2 / a) sum of (-1)^(n / 2) c_n P_n(eta) q_n(zeta),    rho = a sqrt((1 + zeta^2) (1 - eta^2)), z = a zeta eta,

q_n(zeta) = i^(n + 1) Q_n(i zeta) being Legendre's function of the second kind. All that is felt follows from its
derivatives, which are real numbers and as smooth as the circle is wide. Hertz' pressure has two terms, a flat end one.

Source: Hobson, Spherical and Ellipsoidal Harmonics (1931), ch. 10; ``discs`` for the fields.
"""

import math
from functools import lru_cache

import numpy as np

from cnnsim.support import Flags, Floats
from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.core.loads import COLUMNS, F, Q, R, X, Y
from tactile.elastic.gauss import gauss
from tactile.elastic.halfspace import point_scale
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

TORQUE = COLUMNS
TERMS = 32
"""Of even degree, at most."""
NODES = 64
"""Gauss points for their coefficients."""
REST = 0.5
"""Share of the accuracy that the terms left out may take: what is felt changes by less than twice their coefficients
(of a sum of 1) except beside the rim, where sqrt(a / z) times as much."""
LOST = 9.0
"""By the exponential of what going upwards in degree may blow rounding up; beyond, it is gone down from a high one."""


def harmonics(profile: Profile, lam: Floats, size: Floats, accuracy: float) -> tuple[Floats, Flags]:
    """Coefficients (n, terms) of a profile on circles, (-1)^k c_2k, and on which of them so many are enough.

    Arguments: ``lam`` (n,) as in `Profile`; ``size`` (n,): radii in depths; ``accuracy`` of the peak.
    """
    theta, step, legendre = _rule()
    some = lam[:1] if lam.size and (lam == lam[0]).all() else lam
    weight = profile.weight(np.broadcast_to(theta, (len(some), NODES)), some[:, None])
    found = (weight * step) @ legendre
    rest = np.abs(found[:, ::-1]).cumsum(axis=1)[:, ::-1]  # of this one and all above
    needed = rest > REST * accuracy / np.sqrt(np.maximum(size.max(initial=1.0), 1.0))
    terms = max(int(np.count_nonzero(needed, axis=1).max(initial=1)), 1)
    enough = ~needed[:, -2:].any(axis=1)
    return np.ascontiguousarray(found[:, :terms]), np.broadcast_to(enough, lam.shape)


@lru_cache(maxsize=1)
def _rule() -> tuple[Floats, Floats, Floats]:
    """Angles, their weights, and (-1)^k (4 k + 1) / 2 P_2k at their sines (angles, terms)."""
    nodes, weights = gauss(NODES)
    theta = (nodes + 1) * np.pi / 4  # a half: weights are even
    degrees = 2 * np.arange(TERMS)
    legendre = np.polynomial.legendre.legvander(np.sin(theta), 2 * TERMS - 2)[:, ::2]
    signs: Floats = (2 * degrees + 1) / 2 * (-1.0) ** np.arange(TERMS)
    return theta, weights * np.pi / 2, np.asarray(legendre * signs, dtype=np.float64)


def add_wide(
    out: Floats, positions: Floats, depth: float, loads: Floats, radii: Floats, coefficients: Floats, medium: Medium
) -> None:
    """Add to ``out`` (frames, taxels, 3) what taxels feel of loads spread over circles.

    Arguments: ``positions`` (taxels, 2) [m]; ``loads`` (frames, n, 5 or 6) and ``radii`` (frames, n) [m] as
    ``disc_loops.add_discs``, radii of 0 where there is nothing; ``coefficients`` (frames, n or 1, terms) of
    ``harmonics``.
    """
    scale, trace = point_scale(depth, medium)
    rows = np.zeros((*loads.shape[:2], COLUMNS + 1))
    rows[..., : loads.shape[-1]] = loads
    rows[..., [X, Y, TORQUE]] /= depth
    rows[..., Q:] *= scale
    x, y = (np.ascontiguousarray(positions[:, axis]) / depth for axis in (0, 1))
    _add(x, y, rows, np.ascontiguousarray(radii) / depth, np.ascontiguousarray(coefficients), trace, out)


FAST = {"contract", "reassoc", "nsz", "arcp"}


@kept_helper(error_model="numpy", fastmath=FAST)
def _second_kind(zeta, top, over, q):  # type: ignore[no-untyped-def]  # numba types it at the call
    """q_0 .. q_top (see above): upwards, or where that loses digits down from where they are nothing."""
    q[0] = math.atan2(1.0, zeta)
    steep = math.asinh(zeta)
    if 2 * top * steep < LOST:
        if top > 0:
            q[1] = 1 - zeta * q[0]
        for n in range(1, top):
            q[n + 1] = (n * q[n - 1] - (2 * n + 1) * zeta * q[n]) * over[n + 1]
        return
    above, here = 0.0, 1e-300
    for n in range(top + 2 + int(19 / steep), 0, -1):
        below = ((n + 1) * above + (2 * n + 1) * zeta * here) / n
        above, here = here, below
        if here > 1e250:
            above, here = above * 1e-250, here * 1e-250
            for m in range(n, top + 1):
                q[m] *= 1e-250
        if n - 1 <= top:
            q[n - 1] = here
    share = math.atan2(1.0, zeta) / q[0]
    for n in range(top + 1):
        q[n] *= share


@kept_helper(error_model="numpy", fastmath=FAST)
def _potential(square, size, coefficients, over, q):  # type: ignore[no-untyped-def]  # the same
    """(V_rho / rho, V_z, V_rho_z / rho, (V_rho_rho - V_rho / rho) / rho^2) at depth 1, rho^2 and the radius given."""
    # s = zeta^2 - eta^2 and the root, each of the two by the sum that loses nothing
    side = (square + 1) / (size * size) - 1
    root = math.sqrt(side * side + 4 / (size * size))
    if side > 0:
        zeta = math.sqrt((root + side) / 2)
        eta = 1 / (size * zeta)
    else:
        eta = math.sqrt((root - side) / 2)
        zeta = 1 / (size * eta)
    eta = min(eta, 1.0)
    top = 2 * (coefficients.size - 1)
    _second_kind(zeta, top, over, q)
    up, down = 1 + zeta * zeta, 1 - eta * eta
    over_up = 1 / up
    v_z = v_e = v_zz = v_ze = v_ee = 0.0
    p_below, p, dp_below, dp, ddp_below, ddp = 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    for n in range(top + 1):
        if n % 2 == 0:
            c, here = coefficients[n // 2], q[n]
            slope = (n * (zeta * here - q[n - 1]) if n > 0 else -1.0) * over_up
            bend = (n * (n + 1) * here - 2 * zeta * slope) * over_up
            v_z += c * p * slope
            v_e += c * dp * here
            v_zz += c * p * bend
            v_ze += c * dp * slope
            v_ee += c * ddp * here
        p_next = ((2 * n + 1) * eta * p - n * p_below) * over[n + 1]
        dp_next, ddp_next = dp_below + (2 * n + 1) * p, ddp_below + (2 * n + 1) * dp
        p_below, p, dp_below, dp, ddp_below, ddp = p, p_next, dp, dp_next, ddp, ddp_next
    apart = 1 / (size * size * root)  # root = zeta^2 + eta^2
    a = (zeta * v_z - eta * v_e) * apart
    a_z = (v_z + zeta * v_zz - eta * v_ze) * apart - 2 * zeta * a / root
    a_e = (zeta * v_ze - v_e - eta * v_ee) * apart - 2 * eta * a / root
    deeper = 1 / (size * root)
    b = (eta * up * v_z + zeta * down * v_e) * deeper
    c = (eta * up * a_z + zeta * down * a_e) * deeper
    h = (zeta * a_z - eta * a_e) * apart
    whole = 2 / size
    return whole * a, whole * b, whole * c, whole * h


@kept_njit(error_model="numpy", fastmath=FAST)
def _add(x_of, y_of, rows, sizes, coefficients, trace, out):  # type: ignore[no-untyped-def]  # the same
    q, over = np.empty(2 * coefficients.shape[2] + 1), 1 / np.arange(2 * coefficients.shape[2] + 1)
    for n in range(rows.shape[0]):
        for m in range(rows.shape[1]):
            size = sizes[n, m]
            if size == 0:
                continue
            known = coefficients[min(n, coefficients.shape[0] - 1), min(m, coefficients.shape[1] - 1)]
            q_, r_, f_, turn = rows[n, m, Q], rows[n, m, R], rows[n, m, F], rows[n, m, TORQUE]
            for i in range(x_of.size):
                x, y = x_of[i] - rows[n, m, X], y_of[i] - rows[n, m, Y]
                square = x * x + y * y
                a, b, c, h = _potential(square, size, known, over, q)
                s = q_ * x + r_ * y
                out[n, i, 0] += q_ * (b - a) - x * (h * s + f_ * c) + turn * y * c / 2
                out[n, i, 1] += r_ * (b - a) - y * (h * s + f_ * c) - turn * x * c / 2
                out[n, i, 2] += f_ * (b + 2 * a + square * h) - c * s - trace * (a * s + b * f_)
