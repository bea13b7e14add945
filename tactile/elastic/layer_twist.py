"""Twist of a circle that sticks to a bonded layer: its traction as the slope of a pressure, from tables.

Under a twist M the traction across the radius is -M / 2 times the slope of a pressure p of unit force, as on the
half-space, where p is Hertz'. With W the line weight of p (see ``profiles``), g = -W' and the layer's compliance
tanh(k h) / (G k), a rigid rotation of the circle requires

    g(t) - (1 / pi) integral over s = 0 .. a of  (M(t - s) - M(t + s)) g(s) ds  ~  t,

M being the cosine transform of 1 - tanh(k h). Poisson's ratio does not enter. No approximation but the quadrature.

Source: Reissner and Sagoci (1944) for the half-space; Sneddon, Mixed Boundary Value Problems (1966), ch. 4, for g.
"""

from functools import lru_cache

import numpy as np
from scipy.interpolate import RectBivariateSpline

from cnnsim.support import Floats
from tactile.elastic.gauss import gauss
from tactile.elastic.layer_surface import WIDEST, across_excess, cosine_transform
from tactile.elastic.profiles import HERTZ, Profile

RADII, ANGLES = 120, 49
"""In the table; the spline between them is good to 1e-6."""


@lru_cache(maxsize=1)
def layer_twist() -> Profile:
    """Return the pressure p; its lam is the circle's radius over the thickness, at most ``WIDEST``."""
    places = np.linspace(0, np.arcsinh(4 * WIDEST), RADII)
    angles = np.linspace(0, np.pi / 2, ANGLES)
    ratio = np.ones((RADII, ANGLES))
    for n, a in enumerate((np.sinh(places[1:]) / 4).tolist(), 1):
        ratio[n] = _ratio(a, np.sin(angles))
    table = RectBivariateSpline(places, angles, ratio)

    def weight(theta: Floats, lam: Floats) -> Floats:
        at = np.arcsinh(4 * np.broadcast_to(lam, theta.shape))
        out: Floats = HERTZ.weight(theta, lam) * table.ev(at, np.abs(theta))
        return out

    return Profile("twist on a layer", weight)


def _ratio(a: float, at: Floats) -> Floats:
    """Return W over Hertz' at places from 0 to 1 of the radius ``a`` in thicknesses."""
    kernel = cosine_transform(across_excess)
    nodes, weights = gauss(16 + int(4 * a))
    t, step = a * (nodes + 1) / 2, a * weights / 2
    spread = (kernel(np.abs(t[:, None] - t)) - kernel(t[:, None] + t)) * step / np.pi
    slope = np.linalg.solve(np.eye(len(t)) - spread, t)
    # W is the integral of g from t to a, and g a polynomial through the nodes
    degrees = np.arange(len(t))
    series = (np.polynomial.legendre.legvander(nodes, len(t) - 1).T @ (weights * slope)) * (degrees + 0.5)
    whole = np.polynomial.legendre.legint(series, lbnd=1)
    inside = at[:-1]
    found = -a / 2 * np.polynomial.legendre.legval(2 * inside - 1, whole) / (1 - inside**2)
    rim = a / 2 * np.polynomial.legendre.legval(1.0, series)
    unit = 2 * float(step @ (t * slope))
    out: Floats = np.append(found, rim) * 4 * a / (3 * unit)
    return out
