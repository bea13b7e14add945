"""Sum of point loads, compiled: of the closed form on a half-space, of a table on a layer."""

import math

import numpy as np
from numba import get_num_threads, prange
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.core.loads import F, Q, R, X, Y
from tactile.elastic.halfspace import check_loads, point_scale
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ

THICKEST = 1e8
"""Thickness in depths above which a layer is a half-space to rounding."""
SERIAL_BELOW = 200_000
"""Most pairs of loads and taxels that one thread computes: waking the others takes about as long."""
BLOCK = 256
"""Taxels in a block, whose places and sums fit the first-level cache."""
MANY = 24
"""Fewest loads in a frame for which the loop over loads is the inner one."""
FINEST = 1e-7
"""Finest accuracy of the field on a layer."""
FAST = {"contract", "reassoc", "nsz", "arcp"}


def direct_sum(
    positions: ArrayLike, depth: float, loads: ArrayLike, medium: Medium, accuracy: float = FINEST
) -> Floats:
    """Return the readings of taxels in every frame.

    Arguments: ``positions`` (..., 2) taxel centres [m]; ``depth`` z [m]; ``loads`` (frames, n, 5), rows
    (x, y, Q, R, F) [m, m, N, N, N]; ``accuracy`` on a layer, relative to the peak under a load; on a half-space the sum
    is exact to rounding. Returns (frames, ..., 3).

    Raises:
        InputError: as ``halfspace.point_load``; taxels below the layer.
    """
    scale, trace = point_scale(depth, medium)
    at = np.asarray(positions, dtype=np.float64)
    rows = np.ascontiguousarray(check_loads(loads))
    if at.ndim < 1 or at.shape[-1] != 2:
        raise InputError(f"taxel positions of shape {at.shape}, (..., 2) wanted")
    if rows.ndim != 3:
        raise InputError(f"loads of shape {rows.shape}, (frames, n, 5) wanted")
    x, y = (np.ascontiguousarray(at[..., axis]).ravel() for axis in (0, 1))
    frames = len(rows)
    if medium.thickness <= THICKEST * depth:
        from tactile.elastic.disc_loops import add_discs  # these import SciPy's Bessel functions
        from tactile.elastic.disc_table import disc_table

        out, none = np.zeros((frames, x.size, 3)), np.zeros(rows.shape[:2])
        table = disc_table(depth, 0.0, HERTZ, math.inf, medium, accuracy)
        add_discs(out, at.reshape(-1, 2), depth, rows, none, table, medium)
        return out.reshape(frames, *at.shape[:-1], 3)
    out = np.empty((frames, x.size, 3))
    if rows.shape[0] * rows.shape[1] * x.size < SERIAL_BELOW:
        _sum_frames(x, y, rows, out, 0, frames, 1 / depth, trace, scale)
    else:
        _sum_parallel(x, y, rows, out, get_num_threads(), 1 / depth, trace, scale)
    return out.reshape(frames, *at.shape[:-1], 3)


@kept_helper(error_model="numpy", fastmath=FAST)
def _add_load(x_of, y_of, sums, load, over_depth, trace):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Add a load to the sums of a block: three parts of one array, as LLVM does not vectorise over three arrays."""
    x0, y0, q, r, f = load[X], load[Y], load[Q], load[R], load[F]
    for i in range(x_of.size):
        x = (x_of[i] - x0) * over_depth
        y = (y_of[i] - y0) * over_depth
        nearness = 1 / (1 + x * x + y * y)
        weight = (q * x + r * y + f) * (nearness * math.sqrt(nearness))
        along = -3 * (weight * nearness)
        sums[i] += along * x
        sums[i + BLOCK] += along * y
        sums[i + 2 * BLOCK] += weight * trace + along


@kept_helper(error_model="numpy", fastmath=FAST)
def _sum_loads(at_x, at_y, columns, over_depth, trace):  # type: ignore[no-untyped-def]  # the same
    """Sum the columns (5, n) of loads at one taxel."""
    x_of, y_of, q_of, r_of, f_of = columns[X], columns[Y], columns[Q], columns[R], columns[F]
    a = b = c = 0.0
    for j in range(x_of.size):
        x = (at_x - x_of[j]) * over_depth
        y = (at_y - y_of[j]) * over_depth
        nearness = 1 / (1 + x * x + y * y)
        weight = (q_of[j] * x + r_of[j] * y + f_of[j]) * (nearness * math.sqrt(nearness))
        along = -3 * (weight * nearness)
        a += along * x
        b += along * y
        c += weight * trace + along
    return a, b, c


@kept_njit(error_model="numpy")
def _sum_frames(x_of, y_of, loads, out, first, last, over_depth, trace, scale):  # type: ignore[no-untyped-def]  # the same
    """Frames first .. last of out (frames, taxels, 3)."""
    if loads.shape[1] >= MANY:
        for n in range(first, last):
            columns = loads[n].T.copy()
            for i in range(x_of.size):
                a, b, c = _sum_loads(x_of[i], y_of[i], columns, over_depth, trace)
                out[n, i, 0] = scale * a
                out[n, i, 1] = scale * b
                out[n, i, 2] = scale * c
        return
    sums = np.empty(3 * BLOCK)
    for start in range(0, x_of.size, BLOCK):
        count = min(BLOCK, x_of.size - start)
        x_here, y_here = x_of[start : start + count], y_of[start : start + count]
        for n in range(first, last):
            for i in range(count):
                sums[i] = sums[i + BLOCK] = sums[i + 2 * BLOCK] = 0.0
            for m in range(loads.shape[1]):
                if loads[n, m, Q] != 0 or loads[n, m, R] != 0 or loads[n, m, F] != 0:
                    _add_load(x_here, y_here, sums, loads[n, m], over_depth, trace)
            here = out[n, start : start + count]
            for i in range(count):
                here[i, 0] = scale * sums[i]
                here[i, 1] = scale * sums[i + BLOCK]
                here[i, 2] = scale * sums[i + 2 * BLOCK]


@kept_njit(parallel=True, error_model="numpy")
def _sum_parallel(x_of, y_of, loads, out, threads, over_depth, trace, scale):  # type: ignore[no-untyped-def]  # the same
    for thread in prange(threads):
        first, last = thread * out.shape[0] // threads, (thread + 1) * out.shape[0] // threads
        _sum_frames(x_of, y_of, loads, out, first, last, over_depth, trace, scale)
