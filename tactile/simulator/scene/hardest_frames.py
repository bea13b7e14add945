"""The frames of a finger in which its taxels are strained most, by the forces and the distances of the loads."""

from collections.abc import Callable
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS, FORCE, PLACE, F
from tactile.elastic.halfspace import point_scale
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.moving_load import along_path
from tactile.simulator.field import Field

FEW = 24
"""Default number of frames: under several loads near several taxels the first is not always the worst."""
CHUNK = 1 << 14
"""Frames searched in one call."""
STIFFER = 1.5
"""Power of the indentation with which a body's force grows, approximately: used only to compare frames."""
STRAIN = 2.0
"""Largest strain at distance d under a point force P, over K |P| / d^2, in any direction of both."""
BASE = 2.0
"""Largest strain that a rigid base at depth h adds, over K |P| / h^2: for taxels at any depth and any Poisson's ratio.
The largest is the normal strain on the base of an incompressible cover."""


def most_strained(field: Field) -> float:
    """Upper bound of the strain: every contact with its largest force in these frames, all over one taxel at once.

    Under a point force the strain is at most ``STRAIN`` K |P| / d^2; spread loads, which are sums of these, have no
    larger peak. A base adds at most ``BASE`` K |P| / h^2, a Poisson's ratio below 1/2 at most 3 (1 - 2 nu) of both.
    """
    medium, thinner = field.medium, field.taxels.thicker
    depth = field.taxels.depth + (0.0 if thinner is None else float(thinner.min()))
    if depth <= 0 or field.bumps is not None:
        return np.inf
    scale = point_scale(depth, Medium(medium.modulus))[0]
    share = STRAIN + BASE * (depth / medium.thickness) ** 2
    return float(scale * share * (1 + 3 * (1 - 2 * medium.nu)) * _hardest(field).sum())


def hardest_frames(field: Field, frames: int, rate: float, count: int = FEW) -> Floats:
    """Times [s] of the ``count`` frames with the largest sums over the loads of |P| / (d^2 + s^2).

    d is the distance to the nearest taxel, s^2 the mean square radius over which the load is spread at its hardest.

    Arguments: ``field``: at times that include the largest force of every path.
    """
    most = [_strength(contact, field, hard) for contact, hard in zip(field.contacts, _hardest(field), strict=True)]
    spread = _spread(field)
    best, times = np.empty(0), np.empty(0)
    for start in range(0, frames, CHUNK):
        t = np.arange(start, min(start + CHUNK, frames)) / rate
        near = np.zeros(len(t))
        for strength, aside in zip(most, spread, strict=True):
            places, force = strength(t)
            near += force / (_squares(places, field.array, field.taxels.depth) + aside)
        best, times = np.append(best, near), np.append(times, t)
        first = np.argsort(-best, kind="stable")[:count]
        best, times = best[first], times[first]
    return np.sort(times)


def _hardest(field: Field) -> Floats:
    """The largest |P| [N] of every contact: the sum of the sizes of all its loads."""
    loads = field.loads
    sums = np.zeros((loads.totals.shape[1], len(field.times)))
    np.add.at(sums, loads.owner, _sizes(loads.points[..., FORCE]).T)
    for disc in loads.discs:
        np.add.at(sums, disc.owner, _sizes(disc.loads[..., FORCE]).T)
    for pattern in loads.patterns:
        np.add.at(sums, pattern.owner, _sizes(pattern.rows[..., FORCE]))
    for twist in loads.twists:  # its tractions, 3 M r / (4 pi a^3 sqrt(a^2 - r^2)), add up to 3 pi M / 8 a
        wide = np.where(twist.radii > 0, twist.radii, np.inf)
        np.add.at(sums, twist.owner, (3 * np.pi / 8 * np.abs(twist.loads[..., COLUMNS]) / wide).T)
    return np.asarray(sums.max(axis=1, initial=0.0))


def _spread(field: Field) -> Floats:
    """The mean square radius [m^2] of every contact at its hardest; of a circle half its radius squared."""
    loads, square = field.loads, np.zeros(len(field.contacts))
    hard = np.abs(loads.totals[..., F]).argmax(axis=0)
    for disc in loads.discs:
        np.maximum.at(square, disc.owner, disc.radii[hard[disc.owner], np.arange(len(disc.owner))] ** 2 / 2)
    for pattern in loads.patterns:
        (index,) = pattern.owner
        if pattern.rows[hard[index], FORCE].any():
            square[index] = pattern.spread(hard[index])
    for index, at in enumerate(hard.tolist()):
        points = loads.points[at, loads.owner == index]
        if len(points) > 1 and (weight := np.abs(points[:, F])).any():
            apart = points[:, PLACE] - loads.totals[at, index, PLACE]
            square[index] = np.average((apart**2).sum(axis=1), weights=weight)
    return square


def _strength(contact: Any, field: Field, hardest: float) -> Callable[[Floats], tuple[Floats, Floats]]:
    """Function from times to place (n, 2) and force (n,) [N] of a contact; approximate for a path: no contact law."""
    path: Floats | None = getattr(contact, "path", None)
    if path is None:

        def by_loads(t: Floats) -> tuple[Floats, Floats]:
            rows = contact.loads(t, field.taxels.depth, field.medium).totals[:, 0]
            return rows[:, PLACE], _sizes(rows[:, FORCE])

        return by_loads
    if path.shape[1] < COLUMNS:  # a map at a fixed place
        place, most = field.loads.totals[:1, field.contacts.index(contact), PLACE], float(np.abs(path[:, 1]).max()) or 1

        def by_strength(t: Floats) -> tuple[Floats, Floats]:
            strength, gone = along_path(path, t)
            return np.broadcast_to(place, (len(t), 2)), np.abs(strength[:, 0]) / most * hardest * ~gone

        return by_strength
    deepest = max(float(path[:, 1 + F].max()), 1e-300) if getattr(contact, "given_depth", False) else 0.0

    def by_path(t: Floats) -> tuple[Floats, Floats]:
        rows, gone = along_path(path, t)
        if deepest:
            return rows[:, PLACE], hardest * (np.maximum(rows[:, F], 0) / deepest) ** STIFFER * ~gone
        return rows[:, PLACE], _sizes(rows[:, FORCE]) * ~gone

    return by_path


def _sizes(forces: Floats) -> Floats:
    return np.asarray(np.sqrt(np.einsum("...f,...f->...", forces, forces)))


def _squares(places: Floats, array: TaxelArray, depth: float) -> Floats:
    """Squared distance [m^2] from places (n, 2) on the surface to the nearest taxel."""
    square = np.full(len(places), depth**2)
    for axis, count in ((0, array.cols), (1, array.rows)):
        at = (places[:, axis] - array.origin[axis]) / array.pitch + (count - 1) / 2
        square += ((at - np.clip(np.rint(at), 0, count - 1)) * array.pitch) ** 2
    return square
