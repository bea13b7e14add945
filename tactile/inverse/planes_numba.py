"""Answers of all taxels to the readings of a frame, compiled: the taxel inverse for loads that press and that pull."""

import numpy as np

from cnnsim.support.compiled_loops import kept_helper
from tactile.inverse.taxel_numba import BLOCK, strain_blocks, stress_blocks


@kept_helper(error_model="numpy")
def answers(values, strain, times, depth, floor):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return the planes (families, 4, n) of the inverse of readings (rows, cols, 3), no family where all are quiet.

    ``times``: the inverse's scale, 4 pi E z^2 / 3 or 2 pi z^2 / 3; ``depth`` [m]; ``floor``: readings that are quiet.
    """
    rows, cols, _ = values.shape
    n = rows * cols
    signals, quiet = np.empty((3, n)), True
    for i in range(rows):
        for j in range(cols):
            for k in range(3):
                value = values[i, j, k]
                signals[k, i * cols + j] = value
                quiet = quiet and abs(value) <= floor  # not so where it is NaN
    if quiet:
        return np.empty((0, 4, n))
    planes, blocks, tiny = np.empty((2 if strain else 1, 4, n)), -(-n // BLOCK), np.finfo(np.float64).tiny
    for f in range(len(planes)):
        out = planes[f]
        if strain:
            given = times, tiny, depth, floor, 1.0 - 2.0 * f
            strain_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, given)
        else:
            given_two = times, tiny, depth, floor
            stress_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, given_two)
    return planes
