"""One point load from the readings of a frame at one go, compiled: the taxels' inverse, and what their answers say."""

import numpy as np

from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.inverse.answers_numba import NOTHING, answers_point
from tactile.inverse.taxel_numba import BLOCK, strain_blocks, stress_blocks


@kept_njit(error_model="numpy")
def one_point(  # type: ignore[no-untyped-def]  # numba types it
    values, at, scale, trust, strain, layer, numbers, noise, of_attempt, of_fit, limits, of_clipped, of_second, answer
):
    """Fill ``answer`` (19 + n,) with a load as `answers_point` does, or return what else that says.

    ``values`` (rows, cols, 3); ``numbers``: the inverse's scale, 4 pi E z^2 / 3 or 2 pi z^2 / 3, depth [m] and floor;
    the others as for `answers_point`.
    """
    rows, cols, _ = values.shape
    n = rows * cols
    times, depth, floor = numbers
    signals, quiet = np.empty((3, n)), True
    for i in range(rows):
        for j in range(cols):
            for k in range(3):
                value = values[i, j, k]
                signals[k, i * cols + j] = value
                quiet = quiet and abs(value) <= floor  # not so where it is NaN
    if quiet:
        return NOTHING
    planes, blocks, tiny = np.empty((2 if strain else 1, 4, n)), -(-n // BLOCK), np.finfo(np.float64).tiny
    for f in range(len(planes)):
        out = planes[f]
        if strain:
            given = times, tiny, depth, floor, 1.0 - 2.0 * f
            strain_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, given)
        else:
            given_two = times, tiny, depth, floor
            stress_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, given_two)
    return answers_point(
        planes, at, rows, cols, scale, trust, strain, layer, depth, noise, of_attempt, of_fit, limits, of_clipped,
        of_second, answer,
    )  # fmt: skip
