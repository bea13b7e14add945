"""Localisation of point loads by several taxels: their consensus on a place, then least squares to all signals.

Every taxel's inverse leaves up to two candidates, one for each sign of s = Q x + R y + F z, and under shear the
sign may differ from taxel to taxel. Only the true place is common to all of them.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.operations.cellwise import Planes
from cnnsim.support import Flags, Floats, InputError
from tactile.inverse.attempt import DOUBT, Attempt, Taxels
from tactile.inverse.load import INF, NAN, Load
from tactile.inverse.several import EXPLAINED, several, simplest
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights, weigh

POINT = 0.25
"""Loads that leave a larger share of the signals unexplained are not points: a tip of half a depth leaves 0.1."""
FEW = 16
"""With so few taxels every place is tried in doubt."""
PATCH = 0.1
"""What leaves so much may be several loads."""
SHARE = 0.25
"""A taxel that contradicts all others has so much of what is left, unless that is very much."""


def localise(
    positions: Floats, pressing: Planes, pulling: Planes | None, depth: float,
    noise: Weights | Floats | float | None = None,
    saturated: Flags | None = None,
) -> Load:  # fmt: skip
    """Find the point load, or the few, that all taxels of an array feel.

    Start: the weighted mean of the candidates nearest to each other, one a taxel, where a candidate at
    t = rho^2 / z^2 weighs (signal / (1 + t))^2: the inverse variance of its place under equal noise in the signals.
    Then (x, y, Q, R, F) by least squares to the signals of all taxels, and what is left decides: a taxel that
    contradicts all others is left out, several loads are tried where one does not fit. For three taxels without noise
    the components are those of eq. (14).

    Arguments: ``positions`` (rows, cols, 2) of the taxels [m]; ``pressing``: the planes (dx, dy, force, validity)
    of ``invert_strain`` with pressing = 1, or of ``invert_stress``; ``pulling``: those with pressing = -1, None
    for stress; ``depth`` z [m]; ``noise``: standard deviation of the signals, one number or (rows, cols, 3), times
    4 pi E z^2 / 3 for strain and 2 pi z^2 / 3 for stress [N], or what `weigh` makes of it once for many frames; None:
    alike everywhere, judged by what is left;
    ``saturated`` (rows, cols): taxels of which a reading is at the end of its range, marked and left out. Taxels that
    are not INSIDE or OUTSIDE are not used.

    Raises:
        InputError: planes or noise that do not have the array's shape, noise that is not positive.

    Source: Vasarhelyi, Fodor, Roska, eqs (1), (10), (12) to (14).
    """
    families = [pressing] if pulling is None else [pressing, pulling]
    planes = np.array(families, dtype=np.float64)
    if planes.shape[2:] != positions.shape[:2]:
        raise InputError(f"planes of shape {planes.shape[2:]} for an array of {positions.shape[:2]} taxels")
    weights = noise if isinstance(noise, Weights) else weigh(noise, positions.shape[:2])
    at, strain = np.ascontiguousarray(positions, np.float64), pulling is not None
    planes = planes.reshape(len(families), 4, -1)
    railed = None if saturated is None or not saturated.any() else saturated.ravel()
    if railed is not None:
        planes[:, 3, railed] = Validity.INVALID
    taxels = Taxels(at, planes, depth, strain, weights)
    if not taxels.order.size:
        marked = (planes[:, 3] == Validity.INVALID).any()
        named = () if saturated is None else _named(saturated)
        return Load(validity=Validity.INVALID if marked else Validity.NO_LOAD, saturated=named)
    out: tuple[int, ...] = ()
    found = taxels.attempt(taxels.order)
    if found.fit.misfit > DOUBT and taxels.order.size >= 4:
        found, out = _explained(taxels, found)
    load = _load(taxels, found, [divmod(taxel, positions.shape[1]) for taxel in out])
    return load if saturated is None or railed is None else replace(load, saturated=_named(saturated))


def _named(taxels: Flags) -> tuple[tuple[int, int], ...]:
    return tuple((row, col) for row, col in np.argwhere(taxels).tolist())


def three_taxels(x: ArrayLike, y: ArrayLike, m: ArrayLike, depth: float) -> tuple[float, float, float]:
    """Return (Q, R, F) [N] of a load from three taxels, by eq. (14).

    Arguments: ``x``, ``y`` (3,) the taxels seen from the load [m]; ``m`` (3,) Q x_i + R y_i + F z [N m];
    ``depth`` z [m].

    Raises:
        InputError: not three taxels, or three on one line.

    Source: Vasarhelyi, Fodor, Roska, eqs (13), (14).
    """
    xs, ys, ms = (np.asarray(values, dtype=np.float64) for values in (x, y, m))
    if not xs.shape == ys.shape == ms.shape == (3,):
        raise InputError(f"shapes {xs.shape}, {ys.shape}, {ms.shape} given, three taxels wanted")
    (x1, x2, x3), (y1, y2, y3), (m1, m2, m3) = xs.tolist(), ys.tolist(), ms.tolist()
    area = (x2 - x3) * y1 + (x3 - x1) * y2 + (x1 - x2) * y3
    if area == 0:
        raise InputError(f"taxels at x = {xs.tolist()}, y = {ys.tolist()} lie on one line, a triangle wanted")
    q = ((m2 - m3) * y1 + (m3 - m1) * y2 + (m1 - m2) * y3) / area
    r = -((m2 - m3) * x1 + (m3 - m1) * x2 + (m1 - m2) * x3) / area
    f = ((m3 * x2 - m2 * x3) * y1 + (m1 * x3 - m3 * x1) * y2 + (m2 * x1 - m1 * x2) * y3) / (area * depth)
    return q, r, f


def _explained(taxels: Taxels, one: Attempt) -> tuple[Attempt, tuple[int, ...]]:
    """Return the attempt without the taxel that contradicts all others, or with several loads, if it explains more."""
    if one.fit.misfit > POINT or one.order.size <= FEW:
        one = taxels.attempt(one.order, thorough=True)
    if one.fit.misfit <= DOUBT or not _alone(one):
        return one, ()
    suspects = {0, *one.fit.contrary[:3].tolist()} if one.order.size > 4 else set(range(4))
    best = min((taxels.attempt(np.delete(one.order, k)) for k in sorted(suspects)), key=lambda other: other.left)
    ways = [one]
    if best.fit.misfit < POINT and simplest([one, best], POINT) is best:
        ways.append(best)
    if ways[-1].fit.misfit > (PATCH if len(ways) == 1 else EXPLAINED):
        ways += several(taxels, one, POINT)
    found = simplest(ways, POINT)
    return found, tuple(np.setdiff1d(one.order, found.order).tolist())


def _alone(one: Attempt) -> bool:
    """Whether one taxel may be to blame for what is left: it has much of it, or so few taxels hide it."""
    if one.order.size <= 8:
        return True
    worst = one.fit.rest[one.fit.contrary[0]]
    return bool((worst @ worst) > SHARE * one.fit.chi) or one.fit.misfit > PATCH


def _load(taxels: Taxels, found: Attempt, out: list[tuple[int, int]]) -> Load:
    """Return the loads of an attempt in metres and newtons."""
    fit, depth, top = found.fit, taxels.depth, found.top
    seen, tie = fit.signals.seen, fit.signals.tie.tolist()
    (x0, y0), (x1, y1) = taxels.at[found.order[0]].tolist(), seen[0].tolist()
    to_q, to_r = top if tie[0] <= 0 else INF, top if tie[2] <= 0 else INF
    units = depth, depth, to_q, to_r, top
    deviation = math.sqrt(fit.variance)
    loads = []
    for (x, y, q, r, f), spread in zip(fit.loads.tolist(), fit.spread.tolist(), strict=True):
        dx, dy, dq, dr, df = (
            INF if unit == INF else deviation * math.sqrt(one) * unit for one, unit in zip(spread, units, strict=True)
        )
        q, r = q * to_q if to_q < INF else NAN, r * to_r if to_r < INF else NAN
        place = x0 + (x - x1) * depth, y0 + (y - y1) * depth
        validity = _validity(found, x, y)
        loads.append(
            Load(*place, q, r, f * top, (dx, dy, dq, dr, df), fit.misfit, len(found.order), validity, tuple(out))
        )
    first, *others = loads
    return replace(first, others=tuple(others)) if others else first


def _validity(found: Attempt, x: float, y: float) -> Validity:
    """Return what the answer for a load at (x, y) is worth."""
    if found.fit.misfit > POINT:
        return Validity.NOT_ONE
    if found.ambiguous:
        return Validity.AMBIGUOUS
    seen = found.fit.signals.seen
    x1, y1 = seen[0].tolist()
    if (x - x1) ** 2 + (y - y1) ** 2 < 2 or ((seen - (x, y)) ** 2).sum(axis=1).min() < 2:
        return Validity.INSIDE
    return Validity.OUTSIDE
