"""Fields of loads and twists over circles from a table, compiled."""

import math

import numpy as np
from numba import get_num_threads, prange

from cnnsim.support import Floats
from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.core.loads import COLUMNS, F, Q, R, X, Y
from tactile.elastic.disc_table import DiscTable
from tactile.elastic.medium import Medium

TORQUE = COLUMNS
SERIAL_BELOW = 40_000
"""Most pairs of loads and taxels that one thread computes: waking the others takes about as long."""


def add_discs(out: Floats, positions: Floats, depth: float, loads: Floats, radii: Floats, table: DiscTable,
              medium: Medium) -> None:  # fmt: skip
    """Add the readings of taxels under loads spread over circles to ``out`` (frames, taxels, 3).

    Arguments: ``positions`` (taxels, 2) [m]; ``loads`` (frames, n, 5 or 6), rows (x, y, Q, R, F) [m, N] and a twist
    M [N m] about z where there is a sixth; ``radii`` (frames, n) [m], up to the table's largest.
    """
    rows = np.zeros((*loads.shape[:2], COLUMNS + 1))
    rows[..., : loads.shape[-1]] = loads
    rows[..., TORQUE] /= depth
    unit = 1 / depth**2 if medium.quantity == "stress" else 1 / (medium.modulus * depth**2)
    size = np.ascontiguousarray(radii) / depth
    rows[..., Q:] *= (unit / (1 + size**2))[..., None]
    knots = table.knots(size)
    x, y = (np.ascontiguousarray(positions[:, axis]) for axis in (0, 1))
    _, trace = medium.reading
    factor = (1.0 if medium.quantity == "stress" else 1 + medium.nu) / (2 * np.pi)
    numbers = table.numbers, table.per_rho, table.ends, table.endless, 1 / depth, factor, 2 * trace, size
    if rows.shape[0] * rows.shape[1] * len(x) < SERIAL_BELOW:
        _add(x, y, rows, knots, out, 0, len(rows), *numbers)
    else:
        _add_parallel(x, y, rows, knots, out, get_num_threads(), *numbers)


@kept_helper(error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _row_of(numbers, knot, row):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Interpolate the table's row at a radius."""
    if numbers.shape[0] == 1:
        for p in range(numbers.shape[1]):
            for c in range(6):
                row[p, c] = numbers[0, p, c]
        return
    first = min(int(knot), numbers.shape[0] - 4)
    t = knot - first
    a, b = (1 - t) ** 3 / 6, (3 * t**3 - 6 * t**2 + 4) / 6
    d = t**3 / 6
    c_ = 1 - a - b - d
    for p in range(numbers.shape[1]):
        for c in range(6):
            row[p, c] = (
                a * numbers[first, p, c] + b * numbers[first + 1, p, c]
                + c_ * numbers[first + 2, p, c] + d * numbers[first + 3, p, c]
            )  # fmt: skip


@kept_njit(error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _add(x_of, y_of, rows, knots, out, begin, end, numbers, per_rho, ends, endless, over_depth, factor, trace, size):  # type: ignore[no-untyped-def]  # the same
    row = np.empty((numbers.shape[1], 6))
    last = numbers.shape[1] - 4
    for n in range(begin, end):
        known = -1.0
        for m in range(rows.shape[1]):
            x0, y0, q, r, f, turn = (
                rows[n, m, X],
                rows[n, m, Y],
                rows[n, m, Q],
                rows[n, m, R],
                rows[n, m, F],
                rows[n, m, TORQUE],
            )
            if q == 0 and r == 0 and f == 0 and turn == 0:
                continue
            if knots[n, m] != known:
                known = knots[n, m]
                _row_of(numbers, known, row)
            for i in range(x_of.size):
                x, y = (x_of[i] - x0) * over_depth, (y_of[i] - y0) * over_depth
                square = x * x + y * y
                rho = math.sqrt(square)
                if rho >= ends:
                    if endless:  # a point; its weight was divided out
                        near = 1 / (1 + square)
                        weight = (q * x + r * y + f) * near * math.sqrt(near) * factor * (1 + size[n, m] ** 2)
                        out[n, i, 0] -= 3 * weight * near * x
                        out[n, i, 1] -= 3 * weight * near * y
                        out[n, i, 2] += weight * (trace - 3 * near)
                    continue
                root = math.sqrt(1 + square)
                at = math.log(rho + root) * per_rho
                first = min(int(at), last)
                t = at - first
                s = 1 - t
                w0, w3 = s * s * s / 6, t * t * t / 6
                w1 = (3 * t * t * t - 6 * t * t + 4) / 6
                w2 = 1 - w0 - w1 - w3
                zz = w0 * row[first, 0] + w1 * row[first + 1, 0] + w2 * row[first + 2, 0] + w3 * row[first + 3, 0]
                zr = w0 * row[first, 1] + w1 * row[first + 1, 1] + w2 * row[first + 2, 1] + w3 * row[first + 3, 1]
                rz = w0 * row[first, 2] + w1 * row[first + 1, 2] + w2 * row[first + 2, 2] + w3 * row[first + 3, 2]
                even = w0 * row[first, 3] + w1 * row[first + 1, 3] + w2 * row[first + 2, 3] + w3 * row[first + 3, 3]
                odd = w0 * row[first, 4] + w1 * row[first + 1, 4] + w2 * row[first + 2, 4] + w3 * row[first + 3, 4]
                twist = w0 * row[first, 5] + w1 * row[first + 1, 5] + w2 * row[first + 2, 5] + w3 * row[first + 3, 5]
                along, over = q * x + r * y, 1 / root
                odd *= over * over
                out[n, i, 0] += q * even - (2 * along * x - square * q) * odd + (turn * twist * y - f * rz * x) * over
                out[n, i, 1] += r * even - (2 * along * y - square * r) * odd - (turn * twist * x + f * rz * y) * over
                out[n, i, 2] += f * zz - along * zr * over


@kept_njit(parallel=True, error_model="numpy")
def _add_parallel(  # type: ignore[no-untyped-def]  # the same
    x_of, y_of, rows, knots, out, threads, numbers, per_rho, ends, endless, over_depth, factor, trace, size
):
    for thread in prange(threads):
        begin, end = thread * len(rows) // threads, (thread + 1) * len(rows) // threads
        _add(x_of, y_of, rows, knots, out, begin, end, numbers, per_rho, ends, endless, over_depth, factor, trace, size)
