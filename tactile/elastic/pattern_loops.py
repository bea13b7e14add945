"""Sums over load patterns from their tables, compiled: cubic B-splines on the grid that holds a taxel's offset."""

import numpy as np

from cnnsim.support import Floats, Integers
from cnnsim.support.compiled_loops import kept_njit
from tactile.core.loads import F, Q, R, X, Y


def add_pattern(
    out: Floats, positions: Floats, rows: Floats, frames: Integers, weights: Floats,
    numbers: Floats, grids: Floats, columns: int,
) -> None:  # fmt: skip
    """Add to ``out`` (frames, taxels, 3) what taxels feel of a pattern where it is in some of the frames.

    Arguments: ``positions`` (taxels, 2) [m]; ``rows`` (frames, 5) (x, y, Q, R, F) [m, N]; ``frames``, ``weights``
    (n,): in which, and which share of the load has this pattern; ``numbers``: all its grids' coefficients in a row,
    ``grids`` (grids, 9) as `pattern_table.PatternTable` has them; ``columns``: 3 without shear, else 8.
    """
    x, y = (np.ascontiguousarray(positions[:, axis]) for axis in (0, 1))
    _add(x, y, rows, frames, weights, numbers, grids, columns, out)


@kept_njit(error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _add(x_of, y_of, rows, frames, weights, numbers, grids, columns, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    last, long, line = grids.shape[0] - 1, 4 * columns, np.empty(32)
    for m in range(frames.size):
        n = frames[m]
        x0, y0 = rows[n, X], rows[n, Y]
        q, r, f = weights[m] * rows[n, Q], weights[m] * rows[n, R], weights[m] * rows[n, F]
        for i in range(x_of.size):
            x, y = x_of[i] - x0, y_of[i] - y0
            k = 0
            while k <= last and not (abs(x - grids[k, 0]) < grids[k, 2] and abs(y - grids[k, 1]) < grids[k, 3]):
                k += 1
            if k > last:
                continue
            u = (x - grids[k, 0]) * grids[k, 4] + grids[k, 5]
            v = (y - grids[k, 1]) * grids[k, 4] + grids[k, 6]
            a, b = int(u), int(v)
            t = u - a
            s = 1 - t
            u0, u3 = s * s * s / 6, t * t * t / 6
            u1 = (3 * t * t * t - 6 * t * t + 4) / 6
            u2 = 1 - u0 - u1 - u3
            t = v - b
            s = 1 - t
            v0, v3 = s * s * s / 6, t * t * t / 6
            v1 = (3 * t * t * t - 6 * t * t + 4) / 6
            v2 = 1 - v0 - v1 - v3
            step = int(grids[k, 7]) * columns
            first = int(grids[k, 8]) + (b - 1) * step + (a - 1) * columns
            row0, row1 = numbers[first : first + long], numbers[first + step : first + step + long]
            first += 2 * step
            row2, row3 = numbers[first : first + long], numbers[first + step : first + step + long]
            # over the rows first, whose four knots lie side by side: a loop that LLVM makes vector code of, as long as
            # it does not know how long it is
            for c in range(long):
                line[c] = v0 * row0[c] + v1 * row1[c] + v2 * row2[c] + v3 * row3[c]
            for c in range(columns):
                line[c] = (
                    u0 * line[c] + u1 * line[c + columns] + u2 * line[c + 2 * columns] + u3 * line[c + 3 * columns]
                )
            out[n, i, 0] += f * line[0]
            out[n, i, 1] += f * line[1]
            out[n, i, 2] += f * line[2]
            if columns > 3:
                out[n, i, 0] += q * line[3] + r * line[4]
                out[n, i, 1] += q * line[4] + r * line[5]
                out[n, i, 2] += q * line[6] + r * line[7]
