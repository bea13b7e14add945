"""Response of a taxel to unit tractions on one cell of a traction map, as a point or as a rectangle."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, Q
from tactile.elastic.halfspace import point_scale
from tactile.elastic.layer_loads import layer_term, layered_load
from tactile.elastic.medium import Medium


def point_cell(x: ArrayLike, y: ArrayLike, depth: float, pitch: float, medium: Medium) -> Floats:
    """Response (..., 3 components, 3 tractions) at (x, y) [m] from a cell whose traction sits in its middle.

    Unit: reading per Pa. Good where the taxels lie deeper than about two cells.
    """
    at = _places(x, y)
    return np.stack([layered_load(at, depth, load, medium) for load in _units(pitch)], axis=-1)


def _places(x: ArrayLike, y: ArrayLike) -> Floats:
    return np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)), axis=-1)


def _units(pitch: float) -> Floats:
    unit = np.zeros((3, 1, COLUMNS))
    unit[range(3), 0, range(Q, COLUMNS)] = pitch**2
    return unit


def uniform_cell(x: ArrayLike, y: ArrayLike, depth: float, pitch: float, medium: Medium) -> Floats:
    """The same for a traction spread evenly over the square cell: right at any depth.

    Sums over the corners (X, Y) of the antiderivatives of the potential V of the square, as in ``discs``.

    Source: Love (1929); Johnson, Contact Mechanics, sect. 3.3.
    """
    scale, trace = point_scale(depth, medium)
    out: Floats = np.zeros(())
    for sign_x in (1, -1):
        for sign_y in (1, -1):
            a = (np.asarray(x, float) + sign_x * pitch / 2) / depth
            b = (np.asarray(y, float) + sign_y * pitch / 2) / depth
            out = out + sign_x * sign_y * _corner(a + 0 * b, b + 0 * a, trace)
    # point_scale is per area of a depth squared, and the sums above count the cell in that unit
    felt = np.asarray(scale * depth**2 * out)
    if np.isfinite(medium.thickness):
        at = _places(x, y)  # what a layer adds is smooth over a cell that is narrower than the layer is thick
        added = [layer_term(at, depth, load, medium.thickness, medium) for load in _units(pitch)]
        felt = felt + np.stack(added, axis=-1)
    return felt


def _corner(x: Floats, y: Floats, trace: float) -> Floats:
    """T_i and the trace's share at depth 1 for tractions along j, without terms that cancel over the corners."""
    across_x, across_y = 1 + x * x, 1 + y * y
    r = np.sqrt(across_x + y * y)
    v_x, v_y = np.arcsinh(y / np.sqrt(across_x)), np.arcsinh(x / np.sqrt(across_y))
    v_z = -np.arctan2(x * y, r)
    v_xx, v_yy, v_xy = -x * y / (r * across_x), -x * y / (r * across_y), 1 / r
    v_xz, v_yz = -y / (r * across_x), -x / (r * across_y)
    v_zz = -v_xx - v_yy
    rows = (
        (v_z - v_xx, -v_xy, -v_xz),
        (-v_xy, v_z - v_yy, -v_yz),
        (-v_xz - trace * v_x, -v_yz - trace * v_y, v_z - v_zz - trace * v_z),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
