"""Contacts along a line, of an edge or a lying cylinder, as Gauss points; their half width and indentation."""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, FORCE, X, Y
from tactile.elastic.gauss import gauss, panels
from tactile.elastic.medium import Medium

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

MOST_NODES = 2000
"""Most nodes along one direction; longer contacts over shallower taxels are refused."""


def edge_loads(load: ArrayLike, length: float, angle: float, depth: float) -> Floats:
    """Return Gauss points of a straight edge that presses with the same force everywhere.

    The number of nodes grows with length / depth so that the error stays below 1e-10 of the field at that depth.

    Arguments: ``load`` (..., 5) rows (x, y, Q, R, F): middle [m] and total force [N]; ``length`` [m]; ``angle``
    [rad] from x towards y; ``depth`` [m] of the taxels. Returns (..., m, 5).

    Raises:
        InputError: a length or depth that is not positive, or more than 2000 nodes needed.
    """
    nodes, weights = gauss(_count(length / 2, depth))
    return _spread(load, nodes * length / 2, np.zeros(1), weights / 2, np.ones(1), angle)


def cylinder_loads(
    load: ArrayLike, length: float, half_width: ArrayLike, angle: float, depth: float, medium: Medium | None = None
) -> Floats:
    """Return Gauss points of a lying cylinder: uniform along its axis, p ~ sqrt(1 - s^2 / b^2) across.

    Arguments: ``half_width`` b (...) [m] from ``cylinder_half_width``; ``medium``: a layer, on which the pressure
    across is that of ``strip_contact``; the others as ``edge_loads``. The ends carry no stress concentration, as
    if slightly rounded.

    Raises:
        InputError: as ``edge_loads``.

    Source: Johnson, Contact Mechanics, eq. (4.45).
    """
    width = np.asarray(half_width, dtype=np.float64)
    along, along_weights = gauss(_count(length / 2, depth))
    count = _count(max(float(width.max(initial=0)), 1e-12), depth)
    turn = np.arange(1, count + 1) * np.pi / (count + 1)
    across_weights = 2 / (count + 1) * np.sin(turn) ** 2  # Gauss-Chebyshev of the second kind, sum 1
    if medium is not None and np.isfinite(medium.thickness):
        from tactile.elastic.strip_contact import strip_contact  # imports SciPy's splines

        wide = (width / medium.thickness)[..., None]
        across_weights = across_weights * strip_contact(medium.nu).shape(*np.broadcast_arrays(wide, np.cos(turn)))
        across_weights /= across_weights.sum(axis=-1, keepdims=True)
    return _spread(load, along * length / 2, width[..., None] * np.cos(turn), along_weights / 2, across_weights, angle)


def cylinder_half_width(force: ArrayLike, length: float, radius: float, medium: Medium) -> Floats:
    """Return b = sqrt(4 P R / (pi E* L)) [m] on the half-space, that of ``strip_contact`` on a layer.

    Raises:
        InputError: on a layer, a contact beyond the tables.

    Source: Johnson, Contact Mechanics, eq. (4.43).
    """
    pressing = np.maximum(np.asarray(force, dtype=np.float64), 0)
    if np.isfinite(medium.thickness):
        from tactile.elastic.strip_contact import strip_contact  # imports SciPy's splines

        h = medium.thickness
        return strip_contact(medium.nu).width(pressing * radius / (medium.contact_modulus * length * h**2)) * h
    width: Floats = np.sqrt(pressing) * np.sqrt(4 * radius / (np.pi * medium.contact_modulus * length))
    return width


def line_indentation(
    force: ArrayLike, length: float, half_width: Floats, medium: Medium, middle: bool = False
) -> Floats:
    """Return the indentation [m] of a rigid body along a line of length L, 0 where nothing presses.

    It is the mean displacement along the line under a pressure uniform along it and elliptic across 2 b,

        P / (pi E* L) (2 ln(4 L / b) - 1 + (8 / 3 pi) (b / L) - (b / L)^2 / 8).

    The pressure of a rigid body minimises the energy, so that the error of the mean is quadratic in that of the
    pressure: 2 % at most down to L = 4 b. The base of a layer h thick reduces it by 2 / h times the integral from 0
    to L of (1 - x / L) d(r / h) dx, averaged over the pressure across, with d the base's reduction under a point, see
    ``rough_contact``. An incompressible layer much thinner than b is squeezed out at the ends, where the pressure
    falls: there the indentation of the ``middle`` alone is much smaller.

    Arguments: ``force`` P [N] and ``half_width`` b [m], of one shape.

    Source: Johnson, Contact Mechanics, sects 4.2, 5.8; Lundberg (1939) for the middle alone.
    """
    pressing = np.maximum(np.asarray(force, dtype=np.float64), 0)
    narrow = np.maximum(half_width, 1e-12 * length)
    part = narrow / length
    sunk = 2 * np.log(2 / part) + 1 if middle else 2 * np.log(4 / part) - 1 + part * (8 / (3 * np.pi) - part / 8)
    if np.isfinite(medium.thickness):
        sunk = sunk - _base(round(length / medium.thickness, 12), medium.nu, middle)(half_width / medium.thickness)
    out: Floats = pressing * sunk / (np.pi * medium.contact_modulus * length)
    return out


@lru_cache(maxsize=64)
def _base(length: float, nu: float, middle: bool) -> "CubicSpline":
    """Return the reduction of the bracket by the base and the pressure's shape, over the half width in thicknesses."""
    from scipy.interpolate import CubicSpline  # slow to import

    from tactile.elastic.rough_contact import REACH, base_reduction  # the same
    from tactile.elastic.strip_contact import WIDEST, strip_contact  # the same

    far = length / 2 if middle else length
    end = min(far, REACH)
    x, step = panels(end, int(np.ceil(end / 2)))
    step = step * (1.0 if middle else 1 - x / length)
    # across by the angle; its cube moves nodes to the middle, where the line's field has a logarithm
    root, share = gauss(64)
    angle = np.pi / 2 * ((root + 1) / 2) ** 3
    share = share * np.cos(angle) ** 2 * (root + 1) ** 2  # an ellipse, to be of sum 1
    widths = np.concatenate([[0.0], np.geomspace(0.02, WIDEST, 40)])
    taken = np.empty(len(widths))
    for n, b in enumerate(widths.tolist()):
        across = share * strip_contact(nu).shape(np.full(64, b), np.sin(angle))
        across /= across.sum()
        s = b * np.sin(angle)
        reduced = base_reduction(nu)(np.minimum(np.hypot(x, s[:, None]), REACH)) @ step
        # far away the layer does not move: the whole 1 / r of the half-space is removed
        near = np.maximum(s, 1e-9)
        beyond = np.arcsinh(far / near) - np.arcsinh(end / near)
        if not middle:
            beyond -= (np.hypot(length, near) - np.hypot(end, near)) / length
        blunt = 2 * across @ np.log(2 * np.sin(angle)) + 1  # 0 under an ellipse
        taken[n] = 2 * across @ (reduced + beyond) + blunt
    return CubicSpline(widths, taken)


def _count(half: float, depth: float) -> int:
    if not (half > 0 and depth > 0 and np.isfinite(half / depth)):
        raise InputError(f"contact half {half} m long over taxels {depth} m deep, positive lengths wanted")
    # Gauss converges like exp(-2 n asinh(z / half)): 13 is half of ln(1e-11)
    count = int(np.ceil(13 / np.arcsinh(depth / half))) + 3
    if count > MOST_NODES:
        raise InputError(f"a contact {2 * half / depth:.3g} depths long, at most {2 * MOST_NODES / 13:.0f} wanted")
    return count


def _spread(
    load: ArrayLike,
    along: Floats,
    across: Floats,
    along_weights: Floats,
    across_weights: Floats,
    angle: float,
) -> Floats:
    rows = np.asarray(load, dtype=np.float64)
    if rows.ndim < 1 or rows.shape[-1] != COLUMNS:
        raise InputError(f"load of shape {rows.shape}, (..., 5) rows (x, y, Q, R, F) wanted")
    s, t = along[:, None], across[..., None, :]
    weight = along_weights[:, None] * across_weights[..., None, :]  # across by each contact's own width, on a layer
    shape = np.broadcast_shapes(rows.shape[:-1], across.shape[:-1])
    out = np.empty((*shape, *weight.shape[-2:], COLUMNS))
    out[..., X] = rows[..., X, None, None] + s * np.cos(angle) - t * np.sin(angle)
    out[..., Y] = rows[..., Y, None, None] + s * np.sin(angle) + t * np.cos(angle)
    out[..., FORCE] = rows[..., None, None, FORCE] * weight[..., None]
    return out.reshape(*shape, -1, COLUMNS)
