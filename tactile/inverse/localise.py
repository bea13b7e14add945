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
from tactile.elastic.layer_field import layer_field
from tactile.inverse.alternatives import POINT, explained
from tactile.inverse.attempt import DOUBT, UNSURE, Attempt, Taxels
from tactile.inverse.load import INF, NAN, Load
from tactile.inverse.point import of_answers
from tactile.inverse.steadiness import unsteady
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights, weigh
from tactile.inverse.windows import Window, false_taxels, may_be_many, windows_of


def localise(
    positions: Floats, pressing: Planes, pulling: Planes | None, depth: float,
    noise: Weights | Floats | float | None = None,
    saturated: Flags | None = None, thickness: float | None = None,
) -> Load:  # fmt: skip
    """Find the point load, or the few, that all taxels of an array feel.

    Start: the weighted mean of the candidates nearest to each other, one a taxel, where a candidate at
    t = rho^2 / z^2 weighs (signal / (1 + t))^2: the inverse variance of its place under equal noise in the signals.
    Then (x, y, Q, R, F) by least squares to the signals of all taxels, and what is left decides: a taxel that
    contradicts all others is left out, several loads are tried where one does not fit. For three taxels without noise
    the components are those of eq. (14). On pads of more than 16 taxels a side, loads far from each other are located
    each from the taxels around it, any number of them (`tactile.inverse.windows`).

    Arguments: ``positions`` (rows, cols, 2) of the taxels [m]; ``pressing``: the planes (dx, dy, force, validity)
    of ``invert_strain`` with pressing = 1, or of ``invert_stress``; ``pulling``: those with pressing = -1, None
    for stress; ``depth`` z [m]; ``noise``: standard deviation of the signals, one number or (rows, cols, 3), times
    4 pi E z^2 / 3 for strain and 2 pi z^2 / 3 for stress [N], or what `weigh` makes of it once for many frames; None:
    alike everywhere, judged by what is left;
    ``saturated`` (rows, cols): taxels of which a reading is at the end of its range, marked and left out;
    ``thickness`` [m] of the cover, an elastic layer bonded to a rigid base: then the loads fitted are those on it, None
    where it is not known: on the half-space, and the misfit says that they are not. Taxels that are not INSIDE or
    OUTSIDE are not used.

    Raises:
        InputError: planes or noise that do not have the array's shape, noise that is not positive, a cover
            thinner than the taxels lie deep.

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
    layer = layer_field(thickness, depth, strain)
    load = of_answers(at.reshape(-1, 2), planes, depth, strain, weights, layer, positions.shape[:2])
    if load is not None and railed is None:
        return load
    if load is not None and saturated is not None:
        under = tuple(taxel for taxel in load.left_out if not saturated[taxel])
        return replace(load, left_out=under, saturated=_named(saturated))
    return _at_length(Taxels(at, planes, depth, strain, weights, layer), at, saturated)


def _at_length(taxels: Taxels, at: Floats, saturated: Flags | None) -> Load:
    """Return the load, or the few, that the taxels at places (rows, cols, 2) [m] feel, whatever is in doubt."""
    planes, railed = taxels.planes, None if saturated is None or not saturated.any() else saturated.ravel()
    if not taxels.order.size:
        marked = (planes[:, 3] == Validity.INVALID).any()
        named = () if saturated is None else _named(saturated)
        return Load(validity=Validity.INVALID if marked else Validity.NO_LOAD, saturated=named)
    found = taxels.attempt(taxels.order)
    windows = windows_of(at, planes, taxels) if may_be_many(taxels, found) else None
    if windows is None:
        windows = [Window(taxels, explained(taxels, found) if taxels.order.size >= 4 else found, (0, 0))]
    loads = [load for window in windows for load in _loads(window)]
    if (planes[:, 3] == Validity.INVALID).any():
        loads = [_less_unread(load, taxels, railed) for load in loads]
    load = loads[0]
    if len(loads) > 1:
        load = _strongest_first(loads)
        if len(windows) > 1 and (false := false_taxels(taxels)):
            load = replace(load, left_out=tuple(sorted({*load.left_out, *false})))
    clipped = [(window.corner, divmod(cell, window.taxels.shape[1])) for window in windows
               for cell in window.found.clipped]  # fmt: skip
    if not clipped and railed is None:
        return load
    at_end = np.zeros(taxels.shape, bool) if saturated is None else saturated.copy()
    for (row, col), (i, j) in clipped:
        at_end[row + i, col + j] = True
    return replace(load, saturated=_named(at_end))


def _strongest_first(loads: list[Load]) -> Load:
    """Return the first of several loads with the others, and with all taxels that were left out."""
    rank = sorted(
        loads, key=lambda load: -math.hypot(*(0.0 if one != one else one for one in (load.Q, load.R, load.F)))
    )
    out = tuple(sorted({taxel for load in loads for taxel in load.left_out}))
    return replace(rank[0], others=tuple(rank[1:]), left_out=out)


def _less_unread(load: Load, taxels: Taxels, railed: Flags | None) -> Load:
    """Return the load with the taxels under it that have no answer as left out, but those at the end of their range."""
    from tactile.inverse.least_squares.doubt_numba import unread  # numba is slow to import

    cells = np.empty(len(taxels.at))
    count = unread(taxels.at, taxels.planes, load.x, load.y, taxels.depth, cells)
    under = cells[:count].astype(int).tolist()
    some = {divmod(cell, taxels.shape[1]) for cell in under if railed is None or not railed[cell]}
    return replace(load, left_out=tuple(sorted({*load.left_out, *some}))) if some else load


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


def _loads(window: Window) -> list[Load]:
    """Return the loads of a window in metres and newtons."""
    taxels, found, (row, col) = window
    out: tuple[tuple[int, int], ...] = ()
    if len(found.order) < len(taxels.order):
        gone = np.setdiff1d(taxels.order, found.order)
        out = tuple((row + int(k) // taxels.shape[1], col + int(k) % taxels.shape[1]) for k in gone)
    if found.false:
        some = {(row + k // taxels.shape[1], col + k % taxels.shape[1]) for k in found.false}
        out = tuple(sorted({*out, *some}))
    fit, depth, top = found.fit, taxels.depth, found.top
    seen, tie = fit.signals.seen, fit.signals.tie.tolist()
    (x0, y0), (x1, y1) = taxels.at[found.order[0]].tolist(), seen[0].tolist()
    to_q, to_r = top if tie[0] <= 0 else INF, top if tie[2] <= 0 else INF
    units = depth, depth, to_q, to_r, top
    deviation, in_doubt = math.sqrt(fit.variance), found.ambiguous or unsteady(found, left_out=bool(out))
    if fit.signals.noise is None:
        from tactile.inverse.least_squares.student_numba import few  # numba is slow to import

        deviation *= few(fit.free)
    loads = []
    more = fit.unexplained[0]
    for (x, y, q, r, f), spread, beyond in zip(fit.loads.tolist(), fit.spread.tolist(), more.tolist(), strict=True):
        dx, dy, dq, dr, df = (
            INF if unit == INF else deviation * math.sqrt(one) * unit for one, unit in zip(spread, units, strict=True)
        )
        scatter = dx, dy, dq, dr, df
        sx, sy, sq, sr, sf = (
            chance if unit == INF or not left > 0 else math.sqrt(deviation * deviation * one + left) * unit
            for chance, one, left, unit in zip(scatter, spread, beyond, units, strict=True)
        )
        q, r = q * to_q if to_q < INF else NAN, r * to_r if to_r < INF else NAN
        place = x0 + (x - x1) * depth, y0 + (y - y1) * depth
        validity = _validity(found, x, y, in_doubt or sx > UNSURE * depth or sy > UNSURE * depth)
        sigma, count = (sx, sy, sq, sr, sf), len(found.order)
        loads.append(Load(*place, q, r, f * top, sigma, fit.misfit, count, validity, out, scatter=scatter))
    return loads


def _validity(found: Attempt, x: float, y: float, in_doubt: bool) -> Validity:
    """Return what the answer for a load at (x, y) is worth."""
    if found.fit.misfit > (POINT if len(found.fit.loads) == 1 else DOUBT) or found.fit.foreign is not None:
        return Validity.NOT_ONE
    if in_doubt:
        return Validity.AMBIGUOUS
    seen = found.fit.signals.seen
    x1, y1 = seen[0].tolist()
    if (x - x1) ** 2 + (y - y1) ** 2 < 2 or ((seen - (x, y)) ** 2).sum(axis=1).min() < 2:
        return Validity.INSIDE
    return Validity.OUTSIDE
