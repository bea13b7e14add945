"""Inner loops of the direct sum: over taxels for few loads, over loads for many.

LLVM vectorises both: the first keeps its three sums in one small array (it cannot prove that three output planes do
not overlap), the second writes nothing.
"""

import math

import numpy as np
from numba import prange

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.core.loads import F, Q, R, X, Y

BLOCK = 256
"""Taxels in a block, whose places and sums fit the first-level cache."""
MANY = 24
"""Fewest loads in a frame for which the loop over loads is the inner one."""
FAST = {"contract", "reassoc", "nsz", "arcp"}


@kept_helper(error_model="numpy", fastmath=FAST)
def _add_load(x_of, y_of, sums, load, over_depth, trace):  # type: ignore[no-untyped-def]  # numba types it at the call
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
def few_loads(x_of, y_of, loads, out, first, last, over_depth, trace, scale):  # type: ignore[no-untyped-def]  # the same
    """Frames first .. last: out (frames, taxels, 3) from loads (frames, n, 5)."""
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
def few_loads_parallel(x_of, y_of, loads, out, threads, over_depth, trace, scale):  # type: ignore[no-untyped-def]  # the same
    """All frames, divided among the threads."""
    for thread in prange(threads):
        first, last = thread * out.shape[0] // threads, (thread + 1) * out.shape[0] // threads
        few_loads(x_of, y_of, loads, out, first, last, over_depth, trace, scale)


@kept_njit(parallel=True, error_model="numpy")
def many_loads(x_of, y_of, columns, out, threads, over_depth, trace, scale):  # type: ignore[no-untyped-def]  # the same
    """One frame: out (taxels, 3) from the loads' columns (5, n), the taxels divided among the threads."""
    for thread in prange(threads):
        for i in range(thread * x_of.size // threads, (thread + 1) * x_of.size // threads):
            a, b, c = _sum_loads(x_of[i], y_of[i], columns, over_depth, trace)
            out[i, 0] = scale * a
            out[i, 1] = scale * b
            out[i, 2] = scale * c
