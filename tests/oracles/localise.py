"""The consensus of several taxels in plain NumPy, array by array: what the compiled loops are held to."""

import numpy as np
from numpy.typing import NDArray

from cnnsim.operations.cellwise import Planes
from cnnsim.support import Floats
from tactile.inverse.localise import RIVAL, SEEDS, Load
from tactile.inverse.validity import Validity


def localise(positions: Floats, pressing: Planes, pulling: Planes | None, depth: float) -> Load:
    """Return what `tactile.inverse.localise.localise` returns."""
    families = [pressing] if pulling is None else [pressing, pulling]
    planes = np.array(families, dtype=np.float64)
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


def _strain_shape(x: Floats, y: Floats) -> tuple[Floats, tuple[Floats, Floats, Floats], Floats]:
    """Return t, the unit direction of (u_xz, u_yz, u_zz) and their size for s / z = 1, up to a constant: eq. (1).

    ``x``, ``y``: the taxel seen from the load, in depths.
    """
    t = x * x + y * y
    size = np.sqrt((t + 1) * (t + 4))
    return t, (-3 * x / size, -3 * y / size, (t - 2) / size), size / ((t + 1) ** 2 * np.sqrt(t + 1))


def _stress_shape(x: Floats, y: Floats) -> tuple[Floats, tuple[Floats, Floats, Floats], Floats]:
    """The same for (sigma_xz, sigma_yz, sigma_zz): eq. (10)."""
    t = x * x + y * y
    size = np.sqrt(t + 1)
    return t, (-x / size, -y / size, -1 / size), 1 / (t + 1) ** 2


def _least_squares(design: Floats, felt: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(design, felt, rcond=None)[0], np.float64)


def _on_one_line(seen: Floats) -> bool:
    """Whether the places, one of which is (0, 0), spread in one direction only."""
    x, y = seen.T
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    return xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2


def _one_taxel(at: Floats, planes: Floats, usable: NDArray[np.bool_], order: NDArray[np.intp]) -> Load:
    """Return the strongest taxel's own answer for a load that presses without shear."""
    for taxel in order.tolist():
        if usable[taxel, 0]:
            dx, dy, force, validity = planes[taxel, :, 0].tolist()
            x, y = at[taxel].tolist()
            return Load(x=x + dx, y=y + dy, F=force, taxels=1, validity=Validity(int(validity)))
    return Load(validity=Validity.INVALID)
