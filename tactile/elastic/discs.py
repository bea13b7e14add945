"""Strain and stress under tractions over circles on the half-space, for any axisymmetric profile, by quadrature."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, F, Q, R, X, Y
from tactile.elastic.gauss import gauss
from tactile.elastic.halfspace import check_loads, point_scale
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

WIDEST = 100.0
"""Largest radius over depth for which the quadrature is accurate."""
BUDGET = 1 << 21
"""Complex numbers held at once."""


def disc_load(
    positions: ArrayLike,
    depth: float,
    loads: ArrayLike,
    radii: ArrayLike,
    profile: Profile,
    medium: Medium,
    lam: ArrayLike = 0.0,
) -> Floats:
    """Return the strain or stress (the quantity of the medium) under loads spread over circles.

    With V the potential of the profile's unit density, P = (Q, R, F) and (c, n) the medium's reading, a load adds

        T_i = (P_i dV/dz - z P_j d2V/(dx_i dx_j)) / (2 pi),    c (T_x, T_y, T_z - n P . grad(V) / pi)

    and a twist M of a circle that sticks, whose traction is -M/2 times the slope of the unit pressure (under Hertz'
    3 M r / (4 pi a^3 sqrt(a^2 - r^2))), (sigma_xz, sigma_yz) = -(M / 4 pi) d2V/(d rho dz) (-y, x) / rho.

    Arguments: ``positions`` (..., 2) [m]; ``depth`` [m]; ``loads`` (..., n, 5 or 6) rows (x, y, Q, R, F) [m, N], the
    tangential components spread like the normal one, and M [N m], from x to y, where there is a sixth; ``radii``
    (..., n) [m], 0 for a point; ``lam`` (..., n) as in ``Profile``. Returns (..., 3). Good to rounding for radii up to
    three depths, to about 1e-6 of the largest value at 100.

    Raises:
        InputError: wrong shapes, a negative radius, a radius of more than 100 depths.

    Source: Johnson, Contact Mechanics, sects 3.2, 3.6, eq. (3.108); Reissner and Sagoci (1944).
    """
    scale, trace = point_scale(depth, medium)
    at, rows = np.asarray(positions, dtype=np.float64), np.asarray(loads, dtype=np.float64)
    twisted = rows.shape[-1:] == (COLUMNS + 1,)
    check_loads(rows[..., :COLUMNS] if twisted else rows)
    x = (at[..., 0, None] - rows[..., X]) / depth
    y = (at[..., 1, None] - rows[..., Y]) / depth
    size = np.asarray(radii, dtype=np.float64) / depth
    a, b, c, h = potential(np.hypot(x, y), size, profile, np.asarray(lam), (rows[..., Q:] != 0).any(axis=-1))
    q, r, f = rows[..., Q], rows[..., R], rows[..., F]
    s = q * x + r * y
    t_x = q * (b - a) - x * (h * s + f * c)
    t_y = r * (b - a) - y * (h * s + f * c)
    if twisted:
        swirl = rows[..., COLUMNS] / (2 * depth) * c
        t_x, t_y = t_x + swirl * y, t_y - swirl * x
    # d2V/dz2 = -2 a - rho^2 h, for V is harmonic
    t_z = f * (b + 2 * a + (x * x + y * y) * h) - c * s - trace * (a * s + b * f)
    return scale * np.stack([t_x.sum(-1), t_y.sum(-1), t_z.sum(-1)], axis=-1)


def potential(
    rho: Floats, radius: Floats, profile: Profile, lam: Floats, wanted: ArrayLike
) -> tuple[Floats, Floats, Floats, Floats]:
    """(V_rho / rho, V_z, V_rho_z / rho, (V_rho_rho - V_rho / rho) / rho^2) at depth 1, 0 where not ``wanted``.

    Arguments: ``rho`` and ``radius`` in depths, ``lam`` as in ``Profile``, any shapes that broadcast.

    Raises:
        InputError: a negative radius, or one of more than 100 depths.
    """
    shape = np.broadcast_shapes(rho.shape, radius.shape, lam.shape)
    if not (np.isfinite(radius).all() and (radius >= 0).all()):
        raise InputError("contact radii of 0 or more, finite, wanted")
    widest = float(radius.max(initial=0))
    if widest > WIDEST:
        raise InputError(f"a contact {widest:.3g} depths in radius, at most {WIDEST:g} wanted")
    needed = np.broadcast_to(wanted, shape)
    flat = [np.broadcast_to(part, shape)[needed] for part in (rho, radius, lam)]
    found = np.empty((4, flat[0].size))
    count = _nodes(float(flat[1].max(initial=0)))
    chunk = max(1, BUDGET // count)
    for start in range(0, found.shape[1], chunk):
        cut = slice(start, start + chunk)
        found[:, cut] = _line(flat[0][cut], flat[1][cut], profile, flat[2][cut], count)
    out = np.zeros((4, *shape))
    out[:, needed] = found
    a, b, c, h = out
    return a, b, c, h


def _nodes(widest: float) -> int:
    """Return the number of nodes for contacts of a radius in depths, chosen by comparison with twice as many."""
    if widest < 0.05:
        return 12
    return 20 if widest < 0.6 else 40 if widest < 3 else int(50 + 12 * np.log(widest))


def _line(rho: Floats, radius: Floats, profile: Profile, lam: Floats, count: int) -> Floats:
    """Integrate along the line of sources by Gauss points that a sinh moves to where the sources come nearest.

    Source: Johnston and Elliott (2005), for nearly singular integrals.
    """
    nodes, weights = gauss(count)
    floor = np.maximum(radius, 1e-9)  # a point's sources coincide: any small line serves
    near = np.arcsin((rho + 1j) / floor)
    middle, width = near.real, np.abs(near.imag)
    low, high = np.arcsinh((0 - middle) / width), np.arcsinh((np.pi / 2 - middle) / width)
    stretch = ((high + low) / 2)[:, None] + ((high - low) / 2)[:, None] * nodes
    theta = middle[:, None] + width[:, None] * np.sinh(stretch)
    step = ((high - low) / 2 * width)[:, None] * np.cosh(stretch) * weights
    weight = 2 * step * profile.weight(theta, lam[:, None])
    source = 1 + 1j * radius[:, None] * np.sin(theta)
    square = rho[:, None] ** 2 + source * source
    third = weight / (square * np.sqrt(square))
    fifth = third / square
    return np.stack(
        [
            -third.sum(1).real,
            -(third * source).sum(1).real,
            3 * (fifth * source).sum(1).real,
            3 * fifth.sum(1).real,
        ]
    )
