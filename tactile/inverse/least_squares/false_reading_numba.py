"""One false reading among the strongest, compiled: fits of a load without each of those that may be.

Lengths and signals as in `half_space_numba`.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.least_squares.fit import HUNG_ON, LEAST_FREE, SAME, SLIGHT
from tactile.inverse.least_squares.fit_numba import fit

PART = 0.5
"""Fits are tried where one reading explains so much of what is left, to first order."""
AT_NOISE, TOLD = 3.0, 6.0
"""What is left then is noise, up to so many standard deviations of a sum of squares; before it was more by so many
standard deviations of one reading, squared."""
FEW_TIMES = 20.0
"""Where what is left is not known noise it has to be so many times less of a variance."""
NONE, FALSE, ONE_OF_TWO = 0, 1, 2
"""What is said of a reading: it is none that is false; it is; it or another one is, and their loads differ."""


@kept_njit(error_model="numpy")
def may_be_false(chi, excess, free, noise, misfit, most, taken):  # type: ignore[no-untyped-def]
    """Whether fits without one reading are worth their time: ``most``, ``taken`` as `unexplained` has them."""
    if not (excess > 0 if noise > 0 else misfit > SLIGHT and free > LEAST_FREE):
        return False
    return free > 1 and (most > PART * chi or taken > HUNG_ON)


@kept_njit(error_model="numpy")
def false_reading(at, felt, scale, load, strain, layer, tie, chi, steps, first, found):  # type: ignore[no-untyped-def]
    """Return which reading (3 taxel + axis) leaves least if it is not used, chi^2 then and without the next best one.

    ``found`` (2, 5) becomes the loads of both. Tried are the ``first`` one, which explains most to first order, from
    the load that is there, and those of the strongest taxel from the load that the other taxels feel.
    """
    felt, scale, place = felt.copy(), scale.copy(), np.empty((1, 5))
    best, least, second = -1, np.inf, np.inf
    for m in range(5):
        place[0, m] = load[m]
    apart = place.copy()
    fit(at[1:], felt[1:], scale[1:], apart, strain, layer, tie, steps)
    for turn in range(4):
        k = first if turn == 0 else turn - 1
        i, axis = k // 3, k % 3
        was, by = felt[i, axis], scale[i, axis]
        if by == 0:
            continue
        for m in range(5):
            place[0, m] = load[m] if turn == 0 else apart[0, m]
        felt[i, axis] = scale[i, axis] = 0.0
        left, _, _ = fit(at, felt, scale, place, strain, layer, tie, steps)
        felt[i, axis], scale[i, axis] = was, by
        if left < least:
            if k != best:
                second = least
                for m in range(5):
                    found[1, m] = found[0, m]
            best, least = k, left
            for m in range(5):
                found[0, m] = place[0, m]
        elif k != best and left < second:
            second = left
            for m in range(5):
                found[1, m] = place[0, m]
    return best, least, second


@kept_njit(error_model="numpy")
def verdict(chi, left, second, free, noise, found):  # type: ignore[no-untyped-def]
    """Return whether a reading without which ``left`` remains of chi^2 is `FALSE`.

    Where the ``second`` best one explains about as much it is `ONE_OF_TWO` if the loads ``found`` (2, 5) differ.
    """
    rest, one, alone = max(free - 1, 0), noise * noise, False
    if noise > 0 and left <= one * (rest + AT_NOISE * math.sqrt(2.0 * rest)) and chi - left > TOLD * TOLD * one:
        if free <= 1:
            return NONE
        alone = second - left > TOLD * TOLD * one
    elif free > LEAST_FREE and left * FEW_TIMES * free < chi * (free - 1):
        alone = left * FEW_TIMES < second
    else:
        return NONE
    if alone:
        return FALSE
    away = (found[0, 0] - found[1, 0]) ** 2 + (found[0, 1] - found[1, 1]) ** 2
    return ONE_OF_TWO if away > SAME * SAME else NONE
