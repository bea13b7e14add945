"""Contact of a long rigid cylinder with a layer bonded to a rigid base: half width, and pressure across.

With lengths in thicknesses, forces for E* = R = 1, the pressure p over |x| < b solves, as its slope is continuous,

    (2 / pi) integral over s = -b .. b of  p(s) (1 / (x - s) - K(x - s)) ds  =  x,    p(b) = 0,

where K is the sine transform of 1 - T(k), T being the layer's surface compliance over the half-space's. On the
half-space K = 0 and p is an ellipse; on a layer much thinner than b is wide p goes to (b^2 - x^2)^2 where rubber is
incompressible, with P / L = 2 E b^5 / (45 R h^3), and to a parabola where it is not.

Source: Johnson, Contact Mechanics, sect. 5.8; Erdogan and Gupta (1972) for the quadrature.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import BarycentricInterpolator, CubicSpline, RectBivariateSpline

from cnnsim.support import Floats, InputError
from tactile.elastic.gauss import panels
from tactile.elastic.layer_surface import excess

WIDEST = 20.0
"""Half width over thickness where the tables end."""
ACROSS = 65
"""Places in a table from the middle to the rim."""
STEPS = 60
"""Most Newton steps; any width takes five."""


@dataclass(frozen=True)
class StripContact:
    """The tables for a layer of unit thickness and this Poisson's ratio."""

    nu: float

    @cached_property
    def _solved(self) -> tuple[Floats, Floats, Floats]:
        """Half widths, their force per length over that on the half-space, and their pressure over an ellipse."""
        k, weights = panels(24.0, 121)  # exp(-48) is left out; 16 nodes for 8 turns of the fastest wave
        step = excess(k, self.nu) * weights
        x = np.concatenate([np.linspace(0, 8, 401), np.linspace(8, 2 * WIDEST, 401)[1:]])
        slope = CubicSpline(x, np.sin(np.outer(x, k)) @ step)
        widths = np.sinh(np.linspace(0, np.arcsinh(4 * WIDEST), 81))[1:] / 4
        force, shape = np.empty(len(widths)), np.empty((len(widths), ACROSS))
        places = np.sin(np.linspace(0, np.pi / 2, ACROSS))
        for n, b in enumerate(widths.tolist()):
            count = 24 + int(6 * b)
            at = np.cos(np.arange(1, count + 1) * np.pi / (count + 1))
            here = np.cos((np.arange(count + 1) + 0.5) * np.pi / (count + 1))[:, None]
            share = np.pi / (count + 1) * (1 - at**2)
            away = here - at
            turned = np.sign(away) * slope(b * np.abs(away))
            found = np.linalg.lstsq((2 / np.pi) * share * (1 / away - b * turned), here[:, 0], rcond=None)[0]
            whole = float(share @ found)
            force[n] = whole / (np.pi / 4)
            shape[n] = BarycentricInterpolator(at, found)(places) * (np.pi / 2) / whole
        return widths, force, shape

    @cached_property
    def _force(self) -> CubicSpline:
        widths, force, _ = self._solved
        return CubicSpline(np.arcsinh(4 * np.append(0, widths)), np.append(1, force))

    @cached_property
    def _shape(self) -> RectBivariateSpline:
        widths, _, shape = self._solved
        angles = np.linspace(0, np.pi / 2, ACROSS)
        return RectBivariateSpline(np.arcsinh(4 * np.append(0, widths)), angles, np.vstack([np.ones(ACROSS), shape]))

    def force(self, width: Floats) -> Floats:
        """Return the force per length at a half width."""
        out: Floats = self._force(np.arcsinh(4 * width)) * np.pi / 4 * width**2
        return out

    def width(self, force: Floats) -> Floats:
        """Return the half width under a force per length, by Newton's method in logarithms.

        It converges from above, starting at the half-space's width: the force grows like the width squared in narrow
        contacts, and with powers up to the fifth in wide ones.

        Raises:
            InputError: beyond the tables.
        """
        if (force > self.force(np.array(WIDEST))).any():
            raise InputError(
                f"a cylinder's contact over {2 * WIDEST:g} thicknesses of the cover wide; at most that wanted"
            )
        plain = np.where(force > 0, np.sqrt(4 / np.pi * np.maximum(force, 0)), WIDEST)
        width = np.minimum(plain, WIDEST)
        for _ in range(STEPS):
            at = np.arcsinh(4 * width)
            over = self._force(at)
            power = 2 + self._force(at, 1) / over * 4 * width / np.hypot(4 * width, 1)
            after = np.minimum(width * ((plain / width) ** 2 / over) ** (1 / power), WIDEST)
            same = np.abs(after - width) <= 1e-8 * width  # the next step is below rounding
            width = after
            if same.all():
                break
        return np.where(force > 0, width, 0.0)

    def shape(self, width: Floats, at: Floats) -> Floats:
        """Return the pressure over that of an ellipse of the same force, at places from -1 to 1 across."""
        out: Floats = self._shape.ev(np.arcsinh(4 * width), np.arcsin(np.minimum(np.abs(at), 1.0)))
        return out


@lru_cache(maxsize=16)
def strip_contact(nu: float) -> StripContact:
    """Return the tables of one Poisson's ratio, cached."""
    return StripContact(nu)
