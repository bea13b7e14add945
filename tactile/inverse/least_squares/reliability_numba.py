"""How far a load may be off for what it leaves unexplained, compiled: one error in all signals, or one false reading.

Noise is independent from signal to signal; a thin cover, a wide tip or another load is not: more taxels feel more of
the same. What is left beyond the noise therefore counts once, not once for each degree of freedom, as if the part of it
that the load has taken for its own were as large as the part that is seen. Of a reading that the load hangs on little
is seen when it is false: it counts for as much as would hide so, and so does a width of the load (`width_numba`).
Lengths and signals as in `half_space_numba`.

Sources: R. T. Birge, Phys. Rev. 40 (1932) 207; W. Baarda, A testing procedure for use in geodetic networks (1968);
J. G. MacKinnon, H. White, J. Econometrics 29 (1985) 305: the shifts squared are their third estimate.
"""

import math

import numpy as np

from cnnsim.support.compiling.kept_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.equations_numba import equations, slopes
from tactile.inverse.least_squares.fit_numba import back, factored
from tactile.inverse.least_squares.width_numba import width

STRONGEST = 4
"""Of that many of the strongest taxels each reading is asked: no place hangs on one of the others."""
HIDDEN = 1e-6
"""The part of an error in a reading that is seen at least: less is rounding."""
NOTICED = 3.5
"""A reading counts as false from so many standard deviations on: chance does that in one of 200 frames, ..."""
BY_CHANCE = 0.02
"""... or, where nobody knows the noise, where chance would make one of them fit so badly in that part of all frames."""


@kept_helper(error_model="numpy")
def shifts(at, felt, scale, load, strain, layer, tie, moved):  # type: ignore[no-untyped-def]  # numba types it
    """Fill ``moved`` (readings, 5): how far each number of the load is off if that reading of the strongest is false.

    Return what each explains of chi^2 then, and the largest part h of an error in one that the load takes for its own.
    To first order: with J the slopes of a reading, r what is left there, C = (sum J J^T)^-1 of all, h = J^T C J, the
    shift is C J r / (1 - h), and r^2 / (1 - h) of chi^2 is explained.
    """
    matrix, vector, step, factor = np.empty((5, 5)), np.empty(5), np.empty(5), np.empty((5, 5))
    equations(at, felt, scale, load.reshape((1, 5)), strain, layer, matrix, vector)
    matrix[2, 2] += tie[0]
    matrix[3, 2] += tie[1]
    matrix[3, 3] += tie[2]
    count, taken = len(moved) // 3, 0.0
    explained = np.zeros(len(moved))
    moved[:] = 0.0
    if not factored(matrix, 0.0, factor):
        return explained, taken
    left, along = np.zeros((3, count)), np.empty((5, 3, count))
    slopes(at[:count], scale[:count], load, strain, layer, left, along)
    for i in range(count):
        for k in range(3):
            for m in range(5):
                vector[m] = along[m, k, i]
            back(factor, vector, step)
            share = 0.0
            for m in range(5):
                share += vector[m] * step[m]
            taken = max(taken, share)
            seen = max(1 - share, HIDDEN)
            off = felt[i, k] + left[k, i]
            explained[3 * i + k] = off * off / seen
            for m in range(5):
                moved[3 * i + k, m] = step[m] * off / seen
    return explained, taken


@kept_njit(error_model="numpy")
def unexplained(at, felt, scale, load, strain, layer, tie, noise, chi, excess, free, spread, more):  # type: ignore[no-untyped-def]
    """Fill ``more`` (5,): variances of a load beyond those of noise, for what it leaves unexplained.

    Return the most that one reading explains of chi^2, and the largest part of an error in one that the load hides.
    ``noise``: 0 where nobody knows it; ``excess``: the part of chi^2 that is no noise.
    """
    for m in range(5):
        more[m] = excess * spread[m]
    least = NOTICED * NOTICED * noise * noise
    if free < 2 or (noise > 0 and chi <= least):  # no reading explains more than all that is left
        return 0.0, 0.0
    moved = np.empty((3 * min(len(at), STRONGEST), 5))
    explained, taken = shifts(at, felt, scale, load, strain, layer, tie, moved)
    wide = np.empty(5)
    if noise == 0:
        least = chi * (1 - (BY_CHANCE / (len(moved) + 1)) ** (2.0 / (free - 1)))
    in_doubt = noise == 0 or chi > noise * noise * (free + math.sqrt(2.0 * free))
    if in_doubt and width(at, felt, scale, load, strain, layer, tie, wide) > least:
        for m in range(5):
            more[m] += wide[m] * wide[m]
    most = 0.0
    for k in range(len(moved)):
        most = max(most, explained[k])
        if explained[k] > least:
            for m in range(5):
                more[m] += moved[k, m] * moved[k, m]
    return most, taken
