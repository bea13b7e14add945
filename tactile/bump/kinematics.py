"""Kinematics: the displacement gradient in space from displacements on a section, in three geometries.

Rows of the 3 x 3 gradient are the displacement's components, columns the derivative's direction: (x, y, z) in the
plane, (r, theta, z) of a body of revolution, where a load along x makes

    u_r = U(r, z) cos(theta),   u_theta = V(r, z) sin(theta),   u_z = W(r, z) cos(theta)

whose unknowns here are (U + V, U - V, W): on the axis the first and the last vanish. An integral over theta of two such
fields is pi times that of their amplitudes, whether they go with cosines or with sines.

Source: Wilson (1965), Structural analysis of axisymmetric solids.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cnnsim.support import Floats


@dataclass(frozen=True)
class Kinematics:
    """A geometry.

    ``components`` of the unknown displacement; ``gradient(value, slope, r)`` (3, 3, ...) from values (components, ...)
    and slopes (components, directions, ...) at x or radius r; ``around``: factor of areas, times r where
    ``ring``; ``axis``: components that vanish on the axis; ``press`` and ``shift``: a rigid unit displacement
    along z and along x, None where the geometry has no such load.
    """

    components: int
    gradient: Callable[[Floats, Floats, Floats], Floats]
    around: float = 1.0
    ring: bool = False
    axis: tuple[int, ...] = ()
    press: tuple[float, ...] | None = None
    shift: tuple[float, ...] | None = None


def _plane(value: Floats, slope: Floats, r: Floats) -> Floats:
    out = np.zeros((3, 3, *value.shape[1:]))
    out[0, 0], out[0, 2], out[2, 0], out[2, 2] = slope[0, 0], slope[0, 1], slope[1, 0], slope[1, 1]
    return out


def _pressed(value: Floats, slope: Floats, r: Floats) -> Floats:
    out = _plane(value, slope, r)
    out[1, 1] = value[0] / r
    return out


def _sheared(value: Floats, slope: Floats, r: Floats) -> Floats:
    both, along, around = value[0] / r, (slope[0] + slope[1]) / 2, (slope[0] - slope[1]) / 2
    rows = (along[0], -both, along[1]), (around[0], both, around[1]), (slope[2, 0], -value[2] / r, slope[2, 1])
    return np.stack([np.stack(row) for row in rows])


PLANE = Kinematics(2, _plane, press=(0.0, 1.0), shift=(1.0, 0.0))
"""A section (x, z) with nothing along y."""
HALF = replace(PLANE, around=2.0, axis=(0,), shift=None)
"""Half of a symmetric section under a symmetric load."""
PRESSED = Kinematics(2, _pressed, 2 * np.pi, True, (0,), press=(0.0, 1.0))
"""A body of revolution under an axisymmetric load: (u_r, u_z)."""
SHEARED = Kinematics(3, _sheared, np.pi, True, (0, 2), shift=(0.0, 2.0, 0.0))
"""A body of revolution loaded along x: (U + V, U - V, W)."""
