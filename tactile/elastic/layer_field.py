"""Field of a point load on a bonded layer as piecewise polynomials of 1 / sqrt(1 + t), for compiled inverses.

With lengths in depths and the taxel at (x, y) from the load, s = Q x + R y,

    zz = F N - s M,   xz = -x (F S + s O) + Q E,   yz = -y (F S + s O) + R E

where N, M, S, O and E are functions of the distance alone. On the half-space E = 0, and with g = (1 + t)^(-5/2),
t = x^2 + y^2, strain has N = -M = (t - 2) g, S = O = 3 g, stress N = -M = -g, S = O = g: eqs (1) and (10).
"""

from functools import lru_cache

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.elastic.medium import FieldQuantity, Medium

PARTS = 256
"""Intervals of 1 / sqrt(1 + t) from 0, infinitely far, to 1, right above; the spline is good to 1e-7 of the peak."""
THICK = 1e3
"""Thickness in depths above which a layer differs by less than 1e-6 from the half-space."""
HALF_SPACE: Floats = np.empty((0, 5, 4))
"""The half-space: an empty table."""
FARTHEST = 30.0
"""Distance in thicknesses beyond which a bonded layer's field is 0."""


def layer_field(thickness: float | None, depth: float, strain: bool) -> Floats:
    """Return the polynomials (intervals, 5, 4) of N, M, S, O and E over 1 / sqrt(1 + t), Poisson's ratio 1/2.

    Entry (i, f, p) multiplies the p-th power of the share of interval i that is passed. Signals are strains times
    4 pi E z^2 / 3 or stresses times 2 pi z^2 / 3.

    Arguments: ``thickness`` of the layer and ``depth`` z of the taxels [m]; None where the thickness is unknown: the
    table is empty then, as for a layer so thick that it is a half-space. ``strain``: the reading, else stress.

    Raises:
        InputError: taxels that lie deeper than the layer is thick.
    """
    if thickness is None or thickness > THICK * depth:
        return HALF_SPACE
    if not thickness >= depth:
        raise InputError(f"taxels {depth} m deep under a cover of {thickness} m; a cover at least as thick wanted")
    return _table(thickness / depth, "strain" if strain else "stress")


@lru_cache(maxsize=16)
def _table(thickness: float, quantity: FieldQuantity) -> Floats:
    from scipy.interpolate import CubicSpline  # slow to import, and only for layers of a known thickness

    from tactile.elastic.disc_table import point_functions  # imports SciPy's Bessel functions

    near = np.linspace(0, 1, PARTS + 1)
    square = 1 / near[:0:-1] ** 2  # 1 + t, from right above outwards
    rho = np.sqrt(square - 1)
    zz, zr, rz, even, odd, _ = point_functions(rho, 1 / thickness, Medium(1.0, quantity=quantity)).T
    root = np.sqrt(square)
    values = np.stack([zz, zr / root, rz / root, 2 * odd / square, even + odd * (1 - 1 / square)], axis=-1)
    values *= 4 * np.pi / 3 if quantity == "strain" else 2 * np.pi / 3
    values[rho >= FARTHEST * thickness] = 0.0
    spline = CubicSpline(near, np.concatenate([np.zeros((1, 5)), values[::-1]]))
    powers = spline.c[::-1] / PARTS ** np.arange(4)[:, None, None]
    return np.ascontiguousarray(np.moveaxis(powers, 0, -1))
