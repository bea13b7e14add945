"""Direct sum of point loads on a half-space or layer: every load, every taxel, every frame, compiled."""

import numpy as np
from numba import get_num_threads
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.elastic.halfspace import check_loads, point_scale
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct_numba import MANY, few_loads, few_loads_parallel, many_loads

THICKEST = 1e8
"""Depths from which on a layer is a half-space to rounding."""
SERIAL_BELOW = 200_000
"""Most pairs of loads and taxels that one thread computes: waking the others takes about as long."""


def direct_sum(positions: ArrayLike, depth: float, loads: ArrayLike, medium: Medium) -> Floats:
    """Return the readings of taxels in every frame: ``layer_loads.layered_load``, compiled.

    Arguments: ``positions`` (..., 2) taxel centres [m]; ``depth`` z [m]; ``loads`` (frames, n, 5), rows
    (x, y, Q, R, F) [m, m, N, N, N]. Returns (frames, ..., 3).

    Raises:
        InputError: as ``layer_loads.layered_load``.
    """
    scale, trace = point_scale(depth, medium)
    at = np.asarray(positions, dtype=np.float64)
    rows = np.ascontiguousarray(check_loads(loads))
    if at.ndim < 1 or at.shape[-1] != 2:
        raise InputError(f"taxel positions of shape {at.shape}, (..., 2) wanted")
    if rows.ndim != 3:
        raise InputError(f"loads of shape {rows.shape}, (frames, n, 5) wanted")
    x, y = (np.ascontiguousarray(at[..., axis]).ravel() for axis in (0, 1))
    frames, count = rows.shape[:2]
    out = np.empty((frames, x.size, 3))
    numbers = 1 / depth, trace, scale
    if count >= MANY:
        for row, frame in zip(rows, out, strict=True):
            many_loads(x, y, np.ascontiguousarray(row.T), frame, get_num_threads(), *numbers)
    elif frames * x.size * count < SERIAL_BELOW:
        few_loads(x, y, rows, out, 0, frames, *numbers)
    else:
        few_loads_parallel(x, y, rows, out, get_num_threads(), *numbers)
    if medium.thickness <= THICKEST * depth:
        from tactile.elastic.sums.layer_sum import add_layer_term  # compiled

        add_layer_term(out, at.reshape(-1, 2), depth, rows, medium)
    return out.reshape(frames, *at.shape[:-1], 3)
