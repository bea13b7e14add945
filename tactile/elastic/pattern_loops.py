"""Sums over load patterns from their tables, compiled: cubic B-splines on the grid that holds a taxel's offset."""

import numpy as np

from cnnsim.support import Floats, Integers
from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.core.loads import F, Q, R, X, Y


def add_pattern(
    out: Floats, positions: Floats, rows: Floats, frames: Integers, weights: Floats,
    numbers: Floats, grids: Floats, columns: int,
) -> None:  # fmt: skip
    """Add to ``out`` (frames, taxels, 3) what taxels feel of a pattern where it is in some of the frames.

    Arguments: ``positions`` (taxels, 2) [m]; ``rows`` (frames, 5) (x, y, Q, R, F) [m, N]; ``frames``, ``weights``
    (n,): in which, and which share of the load has this pattern; ``numbers``: all its grids' coefficients in a row,
    ``grids`` (grids, 7) as `pattern_table.PatternTable` has them; ``columns``: 3 without shear, else 8.
    """
    x, y = (np.ascontiguousarray(positions[:, axis]) for axis in (0, 1))
    _add(x, y, rows, frames, weights, numbers, grids, columns, out)


@kept_njit(error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _add(x_of, y_of, rows, frames, weights, numbers, grids, columns, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    last = grids.shape[0] - 1
    felt = np.empty(8)
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
            wide, base = int(grids[k, 7]), int(grids[k, 8])
            a, b = int(u), int(v)
            t, w = u - a, v - b
            s = 1 - t
            u0, u3 = s * s * s / 6, t * t * t / 6
            u1 = (3 * t * t * t - 6 * t * t + 4) / 6
            u2 = 1 - u0 - u1 - u3
            s = 1 - w
            v0, v3 = s * s * s / 6, w * w * w / 6
            v1 = (3 * w * w * w - 6 * w * w + 4) / 6
            v2 = 1 - v0 - v1 - v3
            step = wide * columns
            p0 = base + ((b - 1) * wide + a - 1) * columns
            p1, p2, p3 = p0 + step, p0 + 2 * step, p0 + 3 * step
            if columns == 3:
                for c in range(3):
                    felt[c] = 0.0
                for j in range(4):
                    along = u0 if j == 0 else u1 if j == 1 else u2 if j == 2 else u3
                    for c in range(3):
                        felt[c] += along * (
                            v0 * numbers[p0 + c] + v1 * numbers[p1 + c] + v2 * numbers[p2 + c] + v3 * numbers[p3 + c]
                        )
                    p0, p1, p2, p3 = p0 + 3, p1 + 3, p2 + 3, p3 + 3
                out[n, i, 0] += f * felt[0]
                out[n, i, 1] += f * felt[1]
                out[n, i, 2] += f * felt[2]
            else:
                for c in range(8):
                    felt[c] = 0.0
                for j in range(4):
                    along = u0 if j == 0 else u1 if j == 1 else u2 if j == 2 else u3
                    for c in range(8):
                        felt[c] += along * (
                            v0 * numbers[p0 + c] + v1 * numbers[p1 + c] + v2 * numbers[p2 + c] + v3 * numbers[p3 + c]
                        )
                    p0, p1, p2, p3 = p0 + 8, p1 + 8, p2 + 8, p3 + 8
                out[n, i, 0] += f * felt[0] + q * felt[3] + r * felt[4]
                out[n, i, 1] += f * felt[1] + q * felt[4] + r * felt[5]
                out[n, i, 2] += f * felt[2] + q * felt[6] + r * felt[7]
