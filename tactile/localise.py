"""Several taxels, one load: its place by consensus, then its three components.

Every taxel's inverse leaves up to two candidates, one for each sign of s = Q x + R y + F z, and under shear the
sign may differ from taxel to taxel. Only the true place is common to all of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.cellwise import Planes
from cnnsim.errors import InputError
from tactile.inverse import Validity

SEEDS = 3
"""The candidates of that many of the strongest taxels are tried as the place."""
RIVAL = 3.0
"""A second place that fits less than so many times worse than the best leaves the answer ambiguous."""
NAN = float("nan")

Plane = NDArray[np.float64]


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


def localise(positions: Plane, pressing: Planes, pulling: Planes | None, depth: float) -> Load:
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
    at = positions.reshape(-1, 2)
    planes = planes.reshape(len(families), 4, -1).T  # (taxel, plane, family)
    validity = planes[:, 3]
    usable = (validity == Validity.INSIDE) | (validity == Validity.OUTSIDE)
    use = np.flatnonzero(usable.any(1))
    if not use.size:
        marked = (validity == Validity.INVALID).any()
        return Load(validity=Validity.INVALID if marked else Validity.NO_LOAD)
    offset = planes[:, :2] / depth
    shape = _stress_shape if pulling is None else _strain_shape
    t, direction, gain = shape(-offset[:, 0], -offset[:, 1])
    signal = np.where(usable, np.abs(planes[:, 2]) * gain, 0.0)
    order = use[np.argsort(-signal[use].max(1), kind="stable")]
    origin = at[order[0]]
    seen = (at[order] - origin) / depth
    if order.size < 3 or _on_one_line(seen):
        return _one_taxel(at, planes, usable, order)

    # from here on (seed, taxel), lengths in depths, seen from the strongest taxel
    place = np.where(usable[order, None], offset[order] + seen[:, :, None], np.inf)  # (taxel, xy, family)
    seeds = place[:SEEDS].transpose(0, 2, 1).reshape(-1, 2)
    seeds = seeds[usable[order[:SEEDS]].ravel()]
    chosen = ((place - seeds[:, None, :, None]) ** 2).sum(2).argmin(-1)
    picked = place[np.arange(order.size), :, chosen]
    weight = (signal / (1 + t))[order, chosen] ** 2
    total = weight.sum(1)
    centre = (weight[..., None] * picked).sum(1) / total[:, None]
    scatter = (weight * ((picked - centre[:, None]) ** 2).sum(2)).sum(1)
    best = int(scatter.argmin())

    family, spot = chosen[best], centre[best]
    x, y = (seen - spot).T
    _, common, lean = shape(x, y)
    # the part of each taxel's signal that a load at the common place explains: lean_i M_i / z
    cosine = sum(own[order, family] * here for own, here in zip(direction, common, strict=True))
    felt = planes[order, 2, family] * gain[order, family] * cosine
    design = np.array([x, y, np.ones(order.size)]).T * lean[:, None]
    solve = np.linalg.solve if order.size == 3 else _least_squares
    q, r, f = solve(design, felt).tolist()

    rivals = scatter[((centre - spot) ** 2).sum(1) > 0.01]
    code = Validity(int(validity[order[0], family[0]]))
    if rivals.size and rivals.min() < RIVAL * scatter[best]:
        code = Validity.AMBIGUOUS
    residual = float(np.sqrt(scatter[best] / total[best])) * depth
    place_x, place_y = (origin + spot * depth).tolist()
    return Load(place_x, place_y, q, r, f, residual, int(order.size), code)


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


def _strain_shape(x: Plane, y: Plane) -> tuple[Plane, tuple[Plane, Plane, Plane], Plane]:
    """Return t, the unit direction of (u_xz, u_yz, u_zz) and their size for s / z = 1, up to a constant: eq. (1).

    ``x``, ``y``: the taxel seen from the load, in depths.
    """
    t = x * x + y * y
    size = np.sqrt((t + 1) * (t + 4))
    return t, (-3 * x / size, -3 * y / size, (t - 2) / size), size / ((t + 1) ** 2 * np.sqrt(t + 1))


def _stress_shape(x: Plane, y: Plane) -> tuple[Plane, tuple[Plane, Plane, Plane], Plane]:
    """The same for (sigma_xz, sigma_yz, sigma_zz): eq. (10)."""
    t = x * x + y * y
    size = np.sqrt(t + 1)
    return t, (-x / size, -y / size, -1 / size), 1 / (t + 1) ** 2


def _least_squares(design: Plane, felt: Plane) -> Plane:
    return np.asarray(np.linalg.lstsq(design, felt, rcond=None)[0], np.float64)


def _on_one_line(seen: Plane) -> bool:
    """Whether the places, one of which is (0, 0), spread in one direction only."""
    x, y = seen.T
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    return xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2


def _one_taxel(at: Plane, planes: Plane, usable: NDArray[np.bool_], order: NDArray[np.intp]) -> Load:
    """Return the strongest taxel's own answer for a load that presses without shear."""
    for taxel in order.tolist():
        if usable[taxel, 0]:
            dx, dy, force, validity = planes[taxel, :, 0].tolist()
            x, y = at[taxel].tolist()
            return Load(x=x + dx, y=y + dy, F=force, taxels=1, validity=Validity(int(validity)))
    return Load(validity=Validity.INVALID)
