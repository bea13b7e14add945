"""Readings of force taxels: the traction of all loads of a finger, summed over the square area of each taxel.

A point counts where it lies. A circle is cut into rings of known force; of each ring the arc inside a square counts.
"""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.frame import SHEAR_X, SHEAR_Y
from tactile.core.loads import COLUMNS, FORCE, PLACE
from tactile.elastic.gauss import gauss
from tactile.elastic.profiles import Profile

if TYPE_CHECKING:
    from tactile.simulator.contacts.loads import Disc
    from tactile.simulator.field import Field

RINGS = 256
"""Rings of a circle: errors of a taxel's force are below 1e-4 of the force on the circle."""
AT_ONCE = 1 << 21
"""Points times frames that are held in memory."""


def taxel_forces(field: "Field") -> Floats:
    """Return the forces (frames, rows, cols, 3) [N] on the taxels, the normal positive when pressed.

    A taxel is as wide as the pitch, or ``field.taxels.width``. On a layer, the part of a stuck contact's shear traction
    whose sum is 0 is neglected.

    Raises:
        InputError: a twisted contact.
    """
    loads, array = field.loads, field.array
    if loads.twists:
        raise InputError(f"{array.name}: a twisted contact on force taxels; forces alone wanted")
    out = np.zeros((len(field.times), *array.shape, 3))
    _add_points(out, _local(loads.points, field), field)
    for pattern in loads.patterns:
        count = max(1, AT_ONCE // max(1, pattern.count(0.0)))
        for start in range(0, len(out), count):
            part = slice(start, start + count)
            _add_points(out[part], _local(pattern.of_frames(part).points(0.0), field), field)
    for disc in loads.discs:
        _add_disc(out, disc, field)
    if turn := field.taxels.turn:
        c, s = np.cos(turn), np.sin(turn)
        x, y = out[..., SHEAR_X].copy(), out[..., SHEAR_Y].copy()
        out[..., SHEAR_X], out[..., SHEAR_Y] = c * x + s * y, c * y - s * x
    return out


def _local(rows: Floats, field: "Field") -> Floats:
    """Return rows (..., 5) with places [m] from the first taxel, along the array's own axes."""
    apart = rows[..., PLACE] - field.taxels.places[0, 0]
    c, s = np.cos(field.taxels.turn), np.sin(field.taxels.turn)
    places = np.stack([c * apart[..., 0] + s * apart[..., 1], c * apart[..., 1] - s * apart[..., 0]], axis=-1)
    return np.concatenate([places, rows[..., FORCE]], axis=-1)


def _width(field: "Field") -> float:
    return field.taxels.width or field.array.pitch


def _add_points(out: Floats, rows: Floats, field: "Field") -> None:
    """Add point loads ``rows`` (frames, n, 5) to the forces on the taxels under them."""
    pitch, half = field.array.pitch, _width(field) / 2
    cell = np.floor(rows[..., PLACE] / pitch + 0.5)
    inside = ((cell >= 0) & (cell < (field.array.cols, field.array.rows))).all(axis=-1)
    inside &= (np.abs(rows[..., PLACE] - cell * pitch) <= half * (1 + 1e-12)).all(axis=-1)
    frame, _ = np.nonzero(inside)
    col, row = cell[inside].astype(np.int64).T
    np.add.at(out, (frame, row, col), rows[inside][:, [COLUMNS - 3, COLUMNS - 2, COLUMNS - 1]])


def _add_disc(out: Floats, disc: "Disc", field: "Field") -> None:
    """Add loads over circles; a circle of radius 0 is a point."""
    rows = _local(disc.loads, field)
    pressing = (rows[..., FORCE] != 0).any(axis=-1)
    _add_points(out, np.where((pressing & (disc.radii == 0))[..., None], rows, 0), field)
    half, array = _width(field) / 2, field.array
    ends = np.array([-half, half])
    x = (np.arange(array.cols)[:, None] * array.pitch + ends).ravel()
    y = (np.arange(array.rows)[:, None] * array.pitch + ends).ravel()
    for frame, number in zip(*np.nonzero(pressing & (disc.radii > 0)), strict=True):
        load, radius = rows[frame, number], disc.radii[frame, number]
        # most edges lie beyond the circle, on one side of it or the other
        across, col = np.unique(np.clip((x - load[0]) / radius, -1, 1), return_inverse=True)
        along, row = np.unique(np.clip((y - load[1]) / radius, -1, 1), return_inverse=True)
        share = quadrant_share(across, along, disc.profile, radius / disc.unit)[row][:, col]
        # a square is the difference of four quadrants
        squares = np.diff(np.diff(share.reshape(array.rows, 2, array.cols, 2), axis=3), axis=1)[:, 0, :, 0]
        out[frame] += squares[..., None] * load[FORCE]


def quadrant_share(x: Floats, y: Floats, profile: Profile, lam: float) -> Floats:
    """Return the shares (y, x) of the force on the unit circle that lie left of ``x`` and above ``y``, from -1 to 1."""
    ring, force = _rings(profile, lam)
    alpha = np.arccos(np.clip(x[:, None] / ring, -1, 1))  # cos <= x outside (-alpha, alpha)
    beta = np.arcsin(np.clip(y[:, None] / ring, -1, 1))[:, None]  # sin > y inside (beta, pi - beta)
    both = np.maximum(np.minimum(2 * np.pi - alpha, np.pi - beta) - np.maximum(alpha, beta), 0)
    both += np.maximum(-alpha - beta, 0)
    share: Floats = ((2 * np.pi - 2 * alpha - both) @ force) / (2 * np.pi)
    return share


@lru_cache(maxsize=256)
def _rings(profile: Profile, lam: float) -> tuple[Floats, Floats]:
    """Return the radii of the rings and their shares of the force.

    Outside of the radius r lies 2 * integral of w(sqrt(r^2 + s^2)) over s = 0 .. sqrt(1 - r^2), w the line weight of
    the profile.
    """
    theta = np.linspace(0, np.pi / 2, RINGS + 1)  # r = sin(theta)
    nodes, weights = gauss(24)
    bent = np.arccos(np.multiply.outer(np.cos(theta), np.cos((nodes + 1) * np.pi / 4)))
    outside = profile.weight(bent, np.full(bent.shape, lam)) @ weights
    return np.sin((theta[:-1] + theta[1:]) / 2), -np.diff(outside) / (outside[0] - outside[-1])
