"""Tables of the six functions of a circle's load over distance and radius: as fine as the accuracy asks for."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.elastic.medium import Felt, Medium
from tactile.elastic.profiles import Profile
from tactile.elastic.unit_disc import EVEN, ODD, RZ, TWIST, ZR, ZZ, half_space, layer

FAR = 400.0
"""Depths from a load beyond which a circle on the half-space is a point."""
REACH = 30.0
"""Thicknesses beyond which a bonded layer feels nothing: its field dies out exponentially."""
DEEPEST = 1e8
"""A layer of more depths than this is the half-space to rounding."""
KINDS = ([ZZ, RZ], [ZR, EVEN, ODD], [TWIST])
"""Functions of a normal force, of a tangential one, of a twist."""
TAIL = 16.0
"""By so much more than the accuracy the layer's waves have fallen off where they are cut: what is left grows like the
third power of the wavenumber."""
FAINT = 0.01
"""Where a field has fallen to this share of its peak, it still is as accurate: taxels may lie beside what presses."""
SHORTEST = 0.002
"""A step so short has never been needed: what is left is no more the spline's."""
PAD, FALL = 3, 0.27
"""Knots beyond both ends at least, for the spline's own end conditions fall off by so much a knot. At the largest
radius the functions still change: as many as the accuracy asks for."""


@dataclass(frozen=True, eq=False)
class DiscTable:
    """Coefficients of cubic B-splines on even knots, so weighted that they are even and of the order of 1.

    ``numbers`` (radii, distances, 6), the first knot mirrored before the first; ``per_rho``: knots in a unit of
    asinh(rho / z), ``per_radius``: those of the radius' coordinate; ``limit``: the profile's largest radius in depths,
    infinite where it has none; ``ends`` [depths]: nothing is there beyond, but a point's reading where ``endless``.
    """

    numbers: Floats
    per_rho: float
    per_radius: float
    limit: float
    ends: float
    endless: bool

    def knots(self, radii: Floats) -> Floats:
        """Knot numbers of radii in depths."""
        return coordinate(radii, self.limit) * self.per_radius


def coordinate(radius: Floats, limit: float) -> Floats:
    """A radius' coordinate: asinh, or atanh(radius / limit) where a profile changes fast before its largest radius."""
    out: Floats = np.arcsinh(radius) if np.isinf(limit) else np.arctanh(np.minimum(radius / limit, 1 - 1e-12))
    return out


def _radius(along: Any, limit: float) -> Any:
    return np.sinh(along) if np.isinf(limit) else limit * np.tanh(along)


def table_size(radii: Floats, depth: float, profile: Profile, unit: float) -> Floats:
    """The largest coordinate of the table for circles of these radii [m], of a few sizes only so that they share them.

    It depends on a circle's radius alone, so that readings do not depend on what else presses.
    """
    limit = unit / depth * profile.limit
    at = coordinate(radii / depth, limit)
    # a table ten times as wide as its circles costs a hundred times as much; near a profile's largest radius little
    # changes any more, and circles go through many sizes
    sizes = np.ceil(2 * at - 1e-9) / 2 if np.isinf(limit) else 2.0 ** np.ceil(np.log2(np.maximum(at, 1.0)) - 1e-9)
    return np.where(radii > 0, np.maximum(sizes, 1.0), 0.0)


def disc_table(
    depth: float, top: float, profile: Profile, unit: float, medium: Medium, accuracy: float, whole: bool = True
) -> DiscTable:
    """The table for circles of one size, see ``table_size``, over taxels at ``depth`` [m], made once.

    Arguments: ``unit`` [m]: the profile's lam is the radius over it; ``accuracy`` of the peak; ``whole``: with the
    half-space, else only what the layer adds.

    Raises:
        InputError: taxels below the layer; an accuracy that the table does not reach.
    """
    if depth > medium.thickness:
        raise InputError(
            f"taxels {depth} m deep in a layer of {medium.thickness} m, a thickness of at least the depth wanted"
        )
    ratio = depth / medium.thickness if medium.thickness < DEEPEST * depth else 0.0
    return _table(round(ratio, 12), top, profile, unit / depth, medium.nu, medium.quantity, accuracy, whole)


@lru_cache(maxsize=64)
def _table(
    ratio: float, top: float, profile: Profile, unit: float, nu: float, quantity: Felt, accuracy: float, whole: bool
) -> DiscTable:
    medium, limit = Medium(1.0, nu, quantity), unit * profile.limit
    ends = REACH / ratio if ratio else FAR
    fall, beyond = TAIL - np.log(accuracy), max(PAD, int(np.ceil(np.log(accuracy) / np.log(FALL))))
    random = np.random.default_rng(0)
    # a cubic spline is off by about (step / 3)^4 of a function that turns once in a unit
    # and at the rim of a circle of many depths in a depth
    step = min(0.3, 2 * accuracy**0.25) / max(1.0, _radius(top, limit) / 1.5)
    while True:
        distances = int(np.ceil(np.arcsinh(ends) / step)) + 1 + PAD
        across = np.arange(distances) * step
        along = np.zeros(1) if not top else np.arange(int(np.ceil(top / step)) + 1 + beyond) * step
        exact = _weighted(across, along, ratio, profile, unit, limit, medium, whole, fall)
        made = DiscTable(_spline(exact), 1 / step, 1 / step, limit, ends, not ratio)
        # most points where the functions turn, about the rim
        turning, widest = min(np.arcsinh(ends), np.arcsinh(2 * _radius(top, limit)) + 1.5), _radius(top, limit)
        rims = np.minimum(np.arcsinh(widest * random.uniform(0.5, 1.5, 16 if top else 0)), np.arcsinh(ends))
        near = random.uniform(0, 2 * step, 4)
        at = np.concatenate([[0.0], near, rims, random.uniform(0, turning, 32), random.uniform(0, np.arcsinh(ends), 8)])
        of = along if len(along) == 1 else np.concatenate([[top], random.uniform(0, top, 9)])
        wanted = _weighted(at, of, ratio, profile, unit, limit, medium, whole, fall)
        off = max(_off(_read(made, at, of)[..., kind], wanted[..., kind], np.argsort(at)) for kind in KINDS)
        if off < accuracy / 8:
            return made
        if step < SHORTEST:
            raise InputError(
                f"circles {widest:.3g} depths wide to {accuracy:.2g} of the peak; {8 * off:.2g} or more wanted"
            )
        step *= min(0.8, max(0.4, 0.8 * (accuracy / 8 / off) ** 0.25))


def _off(got: Floats, wanted: Floats, order: Integers) -> float:
    """Error of each circle's peak under one kind of load, which on a thin layer falls off otherwise than the weights.

    And a quarter of that of the peak among the distances beyond.
    """
    gap, size = np.abs(got - wanted).max(-1)[:, order], np.abs(wanted).max(-1)[:, order]
    beyond = np.maximum.accumulate(size[:, ::-1], axis=1)[:, ::-1]
    peak = beyond[:, :1]
    return float(np.maximum(gap / peak, gap / np.maximum(beyond, FAINT * peak) / 4).max())


def _weighted(
    across: Floats, along: Floats, ratio: float, profile: Profile, unit: float, limit: float, medium: Medium,
    whole: bool, fall: float,
) -> Floats:  # fmt: skip
    """The six functions (radii, distances, 6), even in both, times 1 + (a / z)^2."""
    rho = np.sinh(across)
    radius = _radius(along, limit)
    lam = radius / unit
    factor, trace = medium.reading
    out = np.zeros((len(radius), len(rho), 6))
    if whole:
        out += half_space(rho, radius, profile, lam, 2 * trace) * (factor / (2 * np.pi))
    if ratio:
        near = rho * ratio <= REACH * 1.5
        added = layer(rho[near] * ratio, radius * ratio, profile, lam, medium, ratio, fall) * ratio**2
        added[..., TWIST] *= ratio
        out[:, near] += added
    # those that vanish at rho = 0 are divided by x and the like, which the loops put back without a division by rho
    apart = np.maximum(rho, 1e-6)
    out[..., [ZR, RZ, TWIST]] *= (np.hypot(1, apart) / apart)[:, None]
    out[..., ODD] *= 1 + apart**-2
    if rho[0] < 1e-6:
        out[:, 0, [ZR, RZ, TWIST, ODD]] = _at_zero(along, ratio, profile, unit, limit, medium, whole, fall)
    weighted: Floats = out * (1 + radius**2)[:, None, None]
    return weighted


def _at_zero(
    along: Floats,
    ratio: float,
    profile: Profile,
    unit: float,
    limit: float,
    medium: Medium,
    whole: bool,
    fall: float,
) -> Floats:
    """What is 0 / 0 right under the load: even functions, so that two values near it tell it to the fourth order."""
    here = np.array([3e-3, 6e-3])
    near = _weighted(here, along, ratio, profile, unit, limit, medium, whole, fall)
    near = (4 * near[:, 0] - near[:, 1]) / 3
    radius = _radius(along, limit)
    return near[:, [ZR, RZ, TWIST, ODD]] / (1 + radius**2)[:, None]


def _spline(values: Floats) -> Floats:
    from scipy.ndimage import spline_filter1d  # SciPy's images only where a table is made

    out = spline_filter1d(values, 3, axis=1, mode="mirror")
    if len(out) > 1:
        out = spline_filter1d(out, 3, axis=0, mode="mirror")
        out = np.concatenate([out[1:2], out])
    return np.ascontiguousarray(np.concatenate([out[:, 1:2], out], axis=1))


def _read(table: DiscTable, across: Floats, along: Floats) -> Floats:
    """The weighted functions at any place: what the loops do, in NumPy."""
    first, rho = _shares(across * table.per_rho)
    picked = np.einsum("pj,rpjc->rpc", rho, table.numbers[:, first[:, None] + np.arange(4)])
    if len(table.numbers) == 1:
        return picked
    row, share = _shares(along * table.per_radius)
    read: Floats = np.einsum("rj,rjpc->rpc", share, picked[row[:, None] + np.arange(4)])
    return read


def _shares(at: Floats) -> tuple[np.ndarray, Floats]:
    knot = np.floor(at).astype(np.int64)
    t = at - knot
    cubes = ((1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3)
    return knot, np.stack(cubes, axis=-1) / 6
