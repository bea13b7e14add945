"""Rigid round bodies on a layer bonded to a rigid base: force, indentation, contact radius and pressure.

The line weight W(t) of the pressure (see ``profiles``) solves, with the half-space's own answer on the right,

    W(t) - (1 / pi) integral over s = -a .. a of  M(t - s) W(s) ds  =  E* (delta - (A f)(t)),

where A f is Abel's transform of the body's shape (t^2 / R for a paraboloid, t atanh(t / R) for a sphere) and M the
cosine transform of 1 - T(k h), T being the layer's surface compliance over the half-space's. Where the body is smooth
W(a) = 0 gives the indentation; the force is the integral of W. No approximation but the quadrature: Dimitriadis et
al.'s series, which is cut at the fourth power of sqrt(R delta) / h, agrees for 0.2 and is 16 % low at 1.

Source: Lebedev and Ufliand (1958); Johnson, Contact Mechanics, sect. 5.8; for T Nogi and Kato (1997).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline, RectBivariateSpline

from cnnsim.support import Floats, InputError
from tactile.elastic.gauss import gauss
from tactile.elastic.layer_surface import WIDEST as WIDEST
from tactile.elastic.layer_surface import cosine_transform, excess, spread
from tactile.elastic.profiles import FLAT_PUNCH, HERTZ, ROUND_TIP, Profile

Body = Literal["paraboloid", "sphere", "flat"]
DEEPEST = 7.0
"""atanh of the contact radius over that of a sphere narrower than that, where its tables end."""
RIM = 0.98
"""Share of the radius up to which weights are divided by the half-space's; at the rim both vanish: extrapolated."""
NARROWEST = 1e-9
"""Smallest contact radius over the largest."""
NEWTON, STEP = 4, 1e-3
"""Newton steps to a radius, and the relative difference for slopes, about the reduction of the error per step."""
SMALL = 0.03
"""Contact over sphere radius below which the force is a series, as its formula cancels."""


@dataclass(frozen=True)
class LayerContact:
    """A body on a layer of unit thickness and contact modulus; ``size``: the radius of a sphere over the thickness.

    A paraboloid has a radius of 1: its indentations and forces are proportional to 1 / R.
    """

    body: Body
    nu: float
    size: float = 1.0

    @cached_property
    def _solved(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Radii, and at them force, indentation, and the weight over the half-space's (radii, places)."""
        if self.ends_at_own_radius:
            radii = self.radius_at(np.linspace(0, DEEPEST, 100))[1:]
        else:
            radii = self.radius_at(np.linspace(0, np.arcsinh(4 * WIDEST), 120))[1:]
        force, depth, ratio = np.empty(len(radii)), np.empty(len(radii)), np.empty((len(radii), 33))
        places = np.linspace(0, RIM, 33)
        for n, a in enumerate(radii.tolist()):
            force[n], depth[n], ratio[n] = self._solve(a, places)
        return radii, force, depth, ratio, places

    def _solve(self, a: float, places: Floats) -> tuple[float, float, Floats]:
        t, step, weight, depth = self.weights(a)
        force = 2 * float(step @ weight)
        here, rim = a * places, np.array([a])
        found = depth - self.abel(here) + self._spread(here, t, step) @ weight
        plain = self.abel(rim)[0] - self.abel(here) if self.body != "flat" else np.ones_like(here)
        inside = 1 / a * 2 * float(step @ (self.abel(rim)[0] - self.abel(t))) if self.body != "flat" else 2.0
        return force, depth, (found * a / force) / (plain / inside)

    def weights(self, a: float) -> tuple[Floats, Floats, Floats, float]:
        """Return places t in 0 .. a, quadrature weights, W at t for a contact of radius a, and the indentation."""
        nodes, weights = gauss(16 + int(4 * a))
        t, step, rim = a * (nodes + 1) / 2, a * weights / 2, np.array([a])
        sides = np.stack([np.ones_like(t), self.abel(t)], axis=-1)
        solved = np.linalg.solve(np.eye(len(t)) - self._spread(t, t, step), sides)
        at_rim = np.stack([np.ones(1), self.abel(rim)], axis=-1) + self._spread(rim, t, step) @ solved
        depth = 1.0 if self.body == "flat" else float(at_rim[0, 1] / at_rim[0, 0])
        return t, step, depth * solved[:, 0] - solved[:, 1], depth

    def _spread(self, at: Floats, t: Floats, step: Floats) -> Floats:
        return spread(cosine_transform(excess, self.nu), at, t, step)

    @property
    def ends_at_own_radius(self) -> bool:
        """Whether the body's own radius ends the tables, not the layer."""
        return self.body == "sphere" and self.size <= WIDEST

    def place(self, radius: Floats) -> Floats:
        """The tables' coordinate of a radius."""
        if self.ends_at_own_radius:
            return np.arctanh(np.minimum(radius / self.size, 1 - 1e-15))
        return np.arcsinh(4 * radius)

    def radius_at(self, place: Floats) -> Floats:
        """The radius at the tables' coordinate."""
        out: Floats = self.size * np.tanh(place) if self.ends_at_own_radius else np.sinh(place) / 4
        return out

    def abel(self, t: Floats) -> Floats:
        """Abel's transform of the body's shape."""
        if self.body == "flat":
            return np.zeros_like(t)
        shape: Floats = t**2 if self.body == "paraboloid" else t * np.arctanh(t / self.size)
        return shape

    @cached_property
    def _force(self) -> CubicSpline:
        """Force over the half-space's at the same radius."""
        radii, force, *_ = self._solved
        return CubicSpline(self.place(np.append(0, radii)), np.append(1, force / self._plain(radii)[0]))

    @cached_property
    def _depth(self) -> CubicSpline:
        radii, _, depth, *_ = self._solved
        return CubicSpline(self.place(np.append(0, radii)), np.append(1, depth / self._plain(radii)[1]))

    def _plain(self, a: Floats) -> tuple[Floats, Floats]:
        """Force and indentation on the half-space at a radius."""
        if self.body == "flat":
            return 2 * a, np.ones_like(a)
        if self.body == "paraboloid":
            return 4 / 3 * a**3, a**2
        lam = a / self.size
        few = lam**3 * (4 / 3 + lam**2 * (8 / 15 + lam**2 * (12 / 35 + 16 / 63 * lam**2)))
        return self.size**2 * np.where(lam < SMALL, few, (lam**2 + 1) * np.arctanh(lam) - lam), a * np.arctanh(lam)

    @property
    def widest(self) -> float:
        """The largest radius in the tables."""
        return float(self._solved[0][-1])

    def force(self, radius: Floats) -> Floats:
        """Force at a contact radius."""
        out: Floats = self._force(self.place(radius)) * self._plain(radius)[0]
        return out

    def indentation(self, radius: Floats) -> Floats:
        """Indentation at a contact radius; of a flat end 1."""
        out: Floats = self._depth(self.place(radius)) * self._plain(radius)[1]
        return out

    def most(self, by: Literal["force", "indentation"]) -> float:
        """The largest force or indentation in the tables."""
        return float(self._first_guesses(by)[1][-1])

    def radius_of(self, wanted: Floats, by: Literal["force", "indentation"]) -> Floats:
        """The contact radius at a force or an indentation, which both grow with it: Newton, in logarithms.

        Raises:
            InputError: beyond the tables.
        """
        law = self.force if by == "force" else self.indentation
        radii, values = self._first_guesses(by)
        if (wanted > values[-1]).any():
            raise InputError(f"{by} {np.max(wanted):.4g} of the layer's units; at most {values[-1]:.4g} wanted")
        aim = np.where(wanted > 0, np.maximum(wanted, values[0]), values[-1])
        out = np.exp(np.interp(np.log(aim), np.log(values), np.log(radii)))
        for _ in range(NEWTON):
            near, aside = law(out), law(out * (1 - STEP))
            # both laws are nearly powers of the radius
            power = np.log(near / aside) / -np.log1p(-STEP)
            out = np.minimum(out * (aim / near) ** (1 / power), self.widest)
        if not (np.abs(law(out) - aim) <= 1e-11 * aim).all():  # where a body's side is steep: bisection
            low, high = np.zeros_like(aim), np.full_like(aim, self.widest)
            for _ in range(54):
                middle = (low + high) / 2
                less = law(middle) < aim
                low, high = np.where(less, middle, low), np.where(less, high, middle)
            out = (low + high) / 2
        return np.where(wanted > 0, out, 0.0)

    def _first_guesses(self, by: Literal["force", "indentation"]) -> tuple[Floats, Floats]:
        """Return radii and the law at them, for first guesses."""
        if by not in self._guesses:
            radii = self.widest * np.geomspace(NARROWEST, 1, 256)
            self._guesses[by] = radii, self.force(radii) if by == "force" else self.indentation(radii)
        return self._guesses[by]

    @cached_property
    def _guesses(self) -> dict[str, tuple[Floats, Floats]]:
        return {}

    @cached_property
    def profile(self) -> Profile:
        """The pressure as a weight; its lam is the contact radius over the thickness."""
        radii, _, _, ratio, places = self._solved
        # through the last four places a cubic in t^2, for the quotient is smooth and even
        square, end = places[-4:] ** 2, np.ones(4)
        for n, one in enumerate(square):
            end[n] = np.prod([(1 - other) / (one - other) for other in np.delete(square, n)])
        every = np.vstack([np.ones(len(places) + 1), np.column_stack([ratio, ratio[:, -4:] @ end])])
        table = RectBivariateSpline(self.place(np.append(0, radii)), np.append(places, 1.0), every)
        plain = {"flat": FLAT_PUNCH, "paraboloid": HERTZ, "sphere": ROUND_TIP}[self.body]
        size = self.size if self.body == "sphere" else np.inf

        def weight(theta: Floats, lam: Floats) -> Floats:
            at, a = np.abs(np.sin(theta)), np.broadcast_to(lam, theta.shape)
            out: Floats = plain.weight(theta, lam / size) * table.ev(self.place(a), at)
            return out

        return Profile(f"{self.body} on a layer", weight, size)


@lru_cache(maxsize=64)
def layer_contact(body: Body, nu: float, size: float = 1.0) -> LayerContact:
    """Return the tables of a body on a layer, cached."""
    return LayerContact(body, nu, size)
