"""Localisation of one load by several taxels: its place by their consensus, then its three components.

Every taxel's inverse leaves up to two candidates, one for each sign of s = Q x + R y + F z, and under shear the
sign may differ from taxel to taxel. Only the true place is common to all of them.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.operations.cellwise import Planes
from cnnsim.support import Floats, InputError
from tactile.inverse.validity import Validity

SEEDS = 3
"""The candidates of that many of the strongest taxels are tried as the place."""
RIVAL = 3.0
"""A second place that fits less than so many times worse than the best leaves the answer ambiguous."""
NAN = float("nan")


@dataclass(frozen=True)
class Load:
    """A located load: place (x, y) [m] in the finger's frame, components (Q, R, F) [N] along x, y and into the body.

    ``residual`` [m]: weighted root mean square distance of the taxels' own answers from (x, y); ``taxels``: how
    many agreed on it; ``validity``: INSIDE or OUTSIDE as seen from the strongest taxel, AMBIGUOUS where another
    place fits about as well, NO_LOAD or INVALID without an answer. With one taxel, or taxels on one line, the
    load is taken to press without shear: then ``taxels`` is 1, Q and R are NaN and the residual is NaN.
    """

    x: float = NAN
    y: float = NAN
    Q: float = NAN
    R: float = NAN
    F: float = NAN
    residual: float = NAN
    taxels: int = 0
    validity: Validity = Validity.NO_LOAD


def localise(positions: Floats, pressing: Planes, pulling: Planes | None, depth: float) -> Load:
    """Find the one load that all taxels of an array feel.

    Location: the weighted mean of the candidates nearest to each other, one a taxel, where a candidate at
    t = rho^2 / z^2 weighs (signal / (1 + t))^2: the inverse variance of its place under equal noise in the signals.
    Components: Q x_i + R y_i + F z = M_i by least squares, each M_i from the part of the taxel's signal that a load
    at the common place explains, weighed as equal noise in the signals asks; for three taxels that is eq. (14).

    Arguments: ``positions`` (rows, cols, 2) of the taxels [m]; ``pressing``: the planes (dx, dy, force, validity)
    of ``invert_strain`` with pressing = 1, or of ``invert_stress``; ``pulling``: those with pressing = -1, None
    for stress; ``depth`` z [m]. Taxels that are not INSIDE or OUTSIDE are left out.

    Raises:
        InputError: planes that do not have the array's shape.

    Source: Vasarhelyi, Fodor, Roska, eqs (12) to (14).
    """
    families = [pressing] if pulling is None else [pressing, pulling]
    planes = np.array(families, dtype=np.float64)
    if planes.shape[2:] != positions.shape[:2]:
        raise InputError(f"planes of shape {planes.shape[2:]} for an array of {positions.shape[:2]} taxels")
    from tactile.inverse import localise_numba as compiled  # numba is slow to import

    at, strain = np.ascontiguousarray(positions, np.float64).reshape(-1, 2), pulling is not None
    planes = planes.reshape(len(families), 4, -1)
    signal, peak, usable = compiled.strongest(planes, depth, strain)
    order = usable[np.argsort(-peak[usable], kind="stable")]
    if not order.size:
        marked = (planes[:, 3] == Validity.INVALID).any()
        return Load(validity=Validity.INVALID if marked else Validity.NO_LOAD)
    seen = (at[order] - at[order[0]]) / depth
    if order.size < 3 or _on_one_line(seen):
        return _one_taxel(at, planes, order)
    x, y, scatter, weight, rival, chosen = compiled.consensus(at, planes, signal, order, depth, strain, SEEDS)
    q, r, f = compiled.components(at, planes, order, chosen, (x, y), depth, strain)
    code = Validity(int(planes[chosen[0], 3, order[0]]))
    if rival < RIVAL * scatter:
        code = Validity.AMBIGUOUS
    place_x, place_y = at[order[0]].tolist()
    return Load(
        place_x + x * depth, place_y + y * depth, q, r, f, math.sqrt(scatter / weight) * depth, order.size, code
    )


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


def _on_one_line(seen: Floats) -> bool:
    """Whether the places, one of which is (0, 0), spread in one direction only."""
    x, y = seen.T
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    return xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2


def _one_taxel(at: Floats, planes: Floats, order: NDArray[np.intp]) -> Load:
    """Return the strongest taxel's own answer for a load that presses without shear."""
    for taxel in order.tolist():
        dx, dy, force, validity = planes[0, :, taxel].tolist()
        if validity in (Validity.INSIDE, Validity.OUTSIDE):
            x, y = at[taxel].tolist()
            return Load(x=x + dx, y=y + dy, F=force, taxels=1, validity=Validity(int(validity)))
    return Load(validity=Validity.INVALID)
