"""Tables of the six response functions of a circle's load over distance and radius, refined to an accuracy."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.profiles import HERTZ, Profile
from tactile.elastic.unit_disc import EVEN, ODD, RZ, TWIST, ZR, ZZ, half_space, layer

FAR = 400.0
"""Depths from a load beyond which a circle on the half-space is a point."""
REACH = 30.0
"""Distance in thicknesses beyond which a bonded layer's field is 0: it decays exponentially."""
DEEPEST = 1e8
"""A layer of more depths than this is the half-space to rounding."""
KINDS = ([ZZ, RZ], [ZR, EVEN, ODD], [TWIST])
"""Functions of a normal force, of a tangential one, of a twist."""
TAIL = 16.0
"""Logarithm by which the layer's waves have decayed beyond the accuracy where they are cut: the remainder grows like
the third power of the wavenumber."""
WHOLE = 46.0
"""The same where the remainder is rounding."""
FAINT = 0.01
"""Share of the peak down to which the error is also limited relative to the local field, for taxels next to a load."""
SHORTEST = 0.002
"""Smallest step: at it the error is no longer the spline's."""
PAD, FALL = 3, 0.27
"""Fewest knots beyond both ends, and the factor per knot by which the spline's end conditions decay. Beyond the largest
radius, where the functions still change, the accuracy sets their number."""


@dataclass(frozen=True, eq=False)
class DiscTable:
    """Coefficients of cubic B-splines on even knots, weighted so that the functions are even and of the order of 1.

    ``numbers`` (radii, distances, 6), the second knot mirrored before the first; ``per_rho``: knots per unit of
    asinh(rho / z); ``per_radius``: knots per unit of ``coordinate``; ``limit``: the profile's largest radius in depths,
    or infinite; ``ends`` [depths]: distance beyond which the field is that of a point where ``endless``, else 0.
    """

    numbers: Floats
    per_rho: float
    per_radius: float
    limit: float
    ends: float
    endless: bool

    def knots(self, radii: Floats) -> Floats:
        """Return the knot numbers of radii in depths."""
        return coordinate(radii, self.limit) * self.per_radius


def coordinate(radius: Floats, limit: float) -> Floats:
    """Return asinh(radius), or atanh(radius / limit) for a profile that changes fast near its largest radius."""
    out: Floats = np.arcsinh(radius) if np.isinf(limit) else np.arctanh(np.minimum(radius / limit, 1 - 1e-12))
    return out


def _radius(along: Any, limit: float) -> Any:
    return np.sinh(along) if np.isinf(limit) else limit * np.tanh(along)


def table_size(radii: Floats, depth: float, profile: Profile, unit: float) -> Floats:
    """Return the largest coordinate of the tables for circles of these radii [m]: one of a few sizes, to share tables.

    It depends on a circle's radius alone, so that readings do not depend on the other loads.
    """
    limit = unit / depth * profile.limit
    at = coordinate(radii / depth, limit)
    # a table ten times as wide as its circles takes a hundred times as long to make
    sizes = np.ceil(2 * at - 1e-9) / 2 if np.isinf(limit) else 2.0 ** np.ceil(np.log2(np.maximum(at, 1.0)) - 1e-9)
    return np.where(radii > 0, np.maximum(sizes, 1.0), 0.0)


def disc_table(
    depth: float, top: float, profile: Profile, unit: float, medium: Medium, accuracy: float, whole: bool = True
) -> DiscTable:
    """Return the table for circles of one size (``table_size``) over taxels at ``depth`` [m], cached.

    Arguments: ``unit`` [m]: the profile's lam is the radius over it; ``accuracy``, relative to the peak; ``whole``:
    the whole field, else only the layer's share.

    Raises:
        InputError: taxels below the layer; an accuracy beyond the smallest step.
    """
    if depth > medium.thickness:
        raise InputError(
            f"taxels {depth} m deep in a layer of {medium.thickness} m, a thickness of at least the depth wanted"
        )
    ratio = depth / medium.thickness if medium.thickness < DEEPEST * depth else 0.0
    return _table(round(ratio, 12), top, profile, unit / depth, medium.nu, medium.quantity, accuracy, whole)


def point_functions(rho: Floats, ratio: float, medium: Medium) -> Floats:
    """Return the six functions (distances, 6) of a point load at distances in depths, from 0 on, in the table's form.

    Arguments: ``ratio`` of the taxels' depth and the layer's thickness.
    """
    return _Functions(ratio, HERTZ, np.inf, medium, True, WHOLE)._even(rho, np.zeros(1))[0]


@lru_cache(maxsize=64)
def _table(
    ratio: float,
    top: float,
    profile: Profile,
    unit: float,
    nu: float,
    quantity: FieldQuantity,
    accuracy: float,
    whole: bool,
) -> DiscTable:
    limit, ends = unit * profile.limit, REACH / ratio if ratio else FAR
    functions = _Functions(ratio, profile, unit, Medium(1.0, nu, quantity), whole, TAIL - np.log(accuracy))
    beyond = max(PAD, int(np.ceil(np.log(accuracy) / np.log(FALL))))
    random, widest = np.random.default_rng(0), _radius(top, limit)
    # a cubic spline's error is about (step / 3)^4 for a function that turns once in a unit, which at the rim of a wide
    # circle is a depth
    step = min(0.3, 2 * accuracy**0.25) / max(1.0, widest / 1.5)
    while True:
        distances = int(np.ceil(np.arcsinh(ends) / step)) + 1 + PAD
        across = np.arange(distances) * step
        along = np.zeros(1) if not top else np.arange(int(np.ceil(top / step)) + 1 + beyond) * step
        exact = functions.weighted(across, along)
        made = DiscTable(_spline(exact), 1 / step, 1 / step, limit, ends, not ratio)
        # test most points near the rim, where the functions turn
        turning = min(np.arcsinh(ends), np.arcsinh(2 * widest) + 1.5)
        rims = np.minimum(np.arcsinh(widest * random.uniform(0.5, 1.5, 16 if top else 0)), np.arcsinh(ends))
        near = random.uniform(0, 2 * step, 4)
        at = np.concatenate([[0.0], near, rims, random.uniform(0, turning, 32), random.uniform(0, np.arcsinh(ends), 8)])
        of = along if len(along) == 1 else np.concatenate([[top], random.uniform(0, top, 9)])
        wanted = functions.weighted(at, of)
        off = max(_off(_read(made, at, of)[..., kind], wanted[..., kind], np.argsort(at)) for kind in KINDS)
        if off < accuracy / 8:
            return made
        if step < SHORTEST:
            raise InputError(
                f"circles {widest:.3g} depths wide to {accuracy:.2g} of the peak; {8 * off:.2g} or more wanted"
            )
        step *= min(0.8, max(0.4, 0.8 * (accuracy / 8 / off) ** 0.25))


@dataclass(frozen=True)
class _Functions:
    """The six functions of a table: ``ratio`` of depth and thickness, 0 on a half-space; ``unit`` of lam in depths.

    ``whole``: with the half-space's; ``fall``: the logarithm by which the layer's waves have decayed at their end.
    """

    ratio: float
    profile: Profile
    unit: float
    medium: Medium
    whole: bool
    fall: float

    def weighted(self, across: Floats, along: Floats) -> Floats:
        """Return the functions (radii, distances, 6), even in both arguments and multiplied by 1 + (a / z)^2."""
        rho, radius = np.sinh(across), _radius(along, self.unit * self.profile.limit)
        return self._even(rho, radius) * (1 + radius**2)[:, None, None]

    def _even(self, rho: Floats, radius: Floats) -> Floats:
        lam, ratio = radius / self.unit, self.ratio
        factor, trace = self.medium.reading
        out = np.zeros((len(radius), len(rho), 6))
        if self.whole:
            out += half_space(rho, radius, self.profile, lam, 2 * trace) * (factor / (2 * np.pi))
        if ratio:
            near = rho * ratio <= REACH * 1.5
            added = layer(rho[near] * ratio, radius * ratio, self.profile, lam, self.medium, ratio, self.fall)
            added *= ratio**2
            added[..., TWIST] *= ratio
            out[:, near] += added
        # functions that vanish at rho = 0 are divided by x or x^2, which the loops multiply back
        apart = np.maximum(rho, 1e-6)
        odd = [ZR, RZ, TWIST, ODD]
        out[..., odd[:3]] *= (np.hypot(1, apart) / apart)[:, None]
        out[..., ODD] *= 1 + apart**-2
        if rho[0] < 1e-6:  # the limits, to the fourth order from two values near it
            close = self._even(np.sinh(np.array([3e-3, 6e-3])), radius)
            out[:, 0, odd] = (4 * close[:, 0, odd] - close[:, 1, odd]) / 3
        return out


def _off(got: Floats, wanted: Floats, order: Integers) -> float:
    """Return the largest error under one kind of load, relative to each circle's peak.

    Or a quarter of it, relative to the peak beyond the same distance, where that is larger.
    """
    gap, size = np.abs(got - wanted).max(-1)[:, order], np.abs(wanted).max(-1)[:, order]
    beyond = np.maximum.accumulate(size[:, ::-1], axis=1)[:, ::-1]
    peak = beyond[:, :1]
    return float(np.maximum(gap / peak, gap / np.maximum(beyond, FAINT * peak) / 4).max())


def _spline(values: Floats) -> Floats:
    from scipy.ndimage import spline_filter1d  # SciPy's images only where a table is made

    out = spline_filter1d(values, 3, axis=1, mode="mirror")
    if len(out) > 1:
        out = spline_filter1d(out, 3, axis=0, mode="mirror")
        out = np.concatenate([out[1:2], out])
    return np.ascontiguousarray(np.concatenate([out[:, 1:2], out], axis=1))


def _read(table: DiscTable, across: Floats, along: Floats) -> Floats:
    """Return the table's functions at any place, as the compiled loops read them."""
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
