"""Statistical tests of the residuals of one point load, compiled: noise, false readings, width, a second load.

The residual of a load beyond the noise counts once, not once for each degree of freedom, because a thin cover or a wide
tip bends all signals alike. An error in one reading, or a width, that the load absorbs counts where it is likely.

Sources: R. T. Birge, Phys. Rev. 40 (1932) 207; W. Baarda, A testing procedure for use in geodetic networks (1968);
J. G. MacKinnon, H. White, J. Econometrics 29 (1985) 305, third estimate; R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc.
90 (1995) 773.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.field_numba import dot, jacobian, residual
from tactile.inverse.fit_numba import invert, least_squares
from tactile.inverse.limits import (
    BY_CHANCE,
    CLIPPED_SIGMAS,
    FALSE_SIGMAS,
    FALSE_TIMES,
    FEW_FREE,
    HIDDEN,
    HIDES,
    LIKELY,
    NEAR_END,
    NOTICED,
    SAME,
    SECOND_APART,
    SLIGHT_MISFIT,
    STEPS,
    STRONGEST,
    WIDEST,
)

SOUND, FALSE, ONE_OF_TWO = 0, 1, 2
"""Verdicts: no reading is false; one is false; one of two is false, and the loads without them differ."""
RADIUS, AROUND = 0.5, 4
"""Radius and number of places of the ring that stands for a width; its mean square radius is that of a ball's contact
of 0.8 depths."""


@kept_njit(error_model="numpy")
def unexplained(data, load, noise, chi, excess, free, covariance, more):  # type: ignore[no-untyped-def]
    """Fill ``more`` (5,): variances of a load from its residuals beyond the noise.

    Return the most that one reading explains of chi^2, the largest part of an error in a reading that the load absorbs,
    the reading (3 taxel + axis) that explains most, and whether the largest reading may be clipped.
    """
    at, measured, scale, strain, layer, _ = data
    for m in range(5):
        more[m] = excess * covariance[m, m]
    if free < 2 or not covariance[0, 0] < np.inf:
        return 0.0, 0.0, 0, False
    count, variance, least = min(len(at), STRONGEST), noise * noise, NOTICED * NOTICED * noise * noise
    if noise == 0:
        variance, least = chi / free, chi * (1 - (BY_CHANCE / (3 * count + 1)) ** (2.0 / (free - 1)))
    left, along = measured[:count].T.copy(), np.empty((5, 3, count))
    jacobian(at[:count], scale[:count], load, strain, layer, left, along)
    largest, at_end = 0.0, 0
    for i in range(len(at)):
        for k in range(3):
            if scale[i, k] > 0:
                largest = max(largest, abs(measured[i, k]) / scale[i, k])
    for i in range(len(at)):
        for k in range(3):
            at_end += scale[i, k] > 0 and abs(measured[i, k]) >= largest * scale[i, k] * (1 - NEAR_END)
    most, hidden, worst, clipped = -1.0, 0.0, 0, at_end > 1
    slopes, step, of_many = np.empty(5), np.empty(5), 2 * math.log(LIKELY * 3 * count)
    for i in range(count):
        for k in range(3):
            for m in range(5):
                slopes[m] = along[m, k, i]
            share = 0.0
            for m in range(5):
                step[m] = dot(covariance[m], slopes)
                share += step[m] * slopes[m]
            read, off, seen = measured[i, k], left[k, i], max(1 - share, HIDDEN)
            explained, hidden = off * off / seen, max(hidden, share)
            if explained > most:
                most, worst = explained, 3 * i + k
            cut = off * read < 0 and abs(read) >= largest * scale[i, k]
            dead = explained - read * read > variance * (math.log(seen) + of_many)
            if cut:
                by_noise = 0 < CLIPPED_SIGMAS * CLIPPED_SIGMAS * noise * noise < 2 * explained
                clipped = clipped or 3 * (chi - explained) <= chi or by_noise
            if (
                dead
                or explained > least
                or (cut and _likely(explained, read * read * seen, variance, noise, chi, free))
            ):
                for m in range(5):
                    more[m] += step[m] ** 2 * (explained + variance) / seen
    if noise == 0 or hidden > HIDES or chi > noise * noise * (free + math.sqrt(2.0 * free)):
        along_it, seen = width(data, load, covariance, step)
        explained = along_it * along_it / seen if seen > 0 else 0.0
        wide = along_it > 0 and _likely(explained, WIDEST * WIDEST * seen, variance, noise, chi, free)
        if explained > least or wide:
            for m in range(5):
                more[m] += step[m] ** 2 * (explained + variance) / seen
    return most, hidden, worst, clipped


@kept_helper(error_model="numpy")
def _likely(explained, range_seen, variance, noise, chi, free):  # type: ignore[no-untyped-def]
    """Whether an error that explains this much of chi^2 has a Bayes factor above `LIKELY`.

    Its prior is flat up to its range, whose square contributes ``range_seen`` to chi^2.
    """
    gain = explained / variance if noise > 0 else -free * math.log(1 - min(explained / chi, 1 - HIDDEN))
    return gain - math.log(max(range_seen / (2 * math.pi * variance), 1.0)) > 2 * math.log(LIKELY)


@kept_njit(error_model="numpy")
def width(data, load, covariance, moved):  # type: ignore[no-untyped-def]
    """Fill ``moved`` (5,): how far a load is off if it has the ring's width; return g' r and g' g'.

    g is what the ring adds to the signals, J the Jacobian, g' = g - J^T C J g its visible part and r the residual; the
    fraction g' r / g' g' of the ring's mean square radius fits best, and C J g is how far the load is off.
    """
    at, measured, scale, strain, layer, _ = data
    ring, nothing = np.empty((AROUND + 1, 5)), np.zeros(measured.shape)
    for m in range(5):
        for k in range(AROUND):
            ring[k, m] = load[m] / AROUND if m > 1 else load[m]
        ring[AROUND, m] = -load[m] if m > 1 else load[m]
    for k in range(AROUND):
        ring[k, 0] += RADIUS * math.cos(2 * math.pi * k / AROUND)
        ring[k, 1] += RADIUS * math.sin(2 * math.pi * k / AROUND)
    added = residual(at, nothing, scale, ring, strain, layer).T.copy().reshape(measured.size)  # -g
    left, along, slope = measured.T.copy(), np.empty((5, 3, len(at))), np.empty(5)
    jacobian(at, scale, load, strain, layer, left, along)
    table, signals = along.reshape((5, measured.size)), left.reshape(measured.size)
    for m in range(5):
        slope[m] = dot(table[m], added)
    seen = dot(added, added)
    for m in range(5):
        moved[m] = dot(covariance[m], slope)
        seen -= moved[m] * slope[m]
    return -dot(added, signals), seen


@kept_njit(error_model="numpy")
def second_load(data, load, covariance, left):  # type: ignore[no-untyped-def]
    """Return the taxel beyond `SECOND_APART` with the largest residual, the normal force of a load above it and the
    share of chi^2 that this load explains to first order; -1 where there is none.
    """
    at, measured, scale, strain, layer, _ = data
    worst, most, chi = -1, 0.0, 0.0
    for i in range(len(at)):
        own = left[i, 0] ** 2 + left[i, 1] ** 2 + left[i, 2] ** 2
        chi += own
        far = (at[i, 0] - load[0]) ** 2 + (at[i, 1] - load[1]) ** 2
        if own > most and far > SECOND_APART * SECOND_APART:
            worst, most = i, own
    if worst < 0:
        return -1, 0.0, 0.0
    nothing, trial = np.zeros((3, len(at))), np.zeros(5)
    trial[0], trial[1], trial[4] = at[worst, 0], at[worst, 1], 1.0
    along, second = np.empty((5, 3, len(at))), np.empty((5, 3, len(at)))
    jacobian(at, scale, load, strain, layer, nothing, along)
    jacobian(at, scale, trial, strain, layer, nothing, second)
    table, other = along.reshape((5, measured.size)), second.reshape((5, measured.size))
    matrix, inverse, vector = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    cross, signals = np.empty((3, 5)), left.T.copy().reshape(measured.size)
    for m in range(3):  # x, y and F of the second load
        row = other[m if m < 2 else 4]
        vector[m] = dot(row, signals)
        for n in range(5):
            cross[m, n] = dot(row, table[n])
        for n in range(m + 1):
            total = dot(row, other[n if n < 2 else 4])
            for k in range(5):
                total -= dot(covariance[k], cross[m]) * cross[n, k]
            matrix[m, n] = matrix[n, m] = total
    if not invert(matrix, 0.0, inverse):
        return -1, 0.0, 0.0
    explained = 0.0
    for m in range(3):
        explained += vector[m] * dot(inverse[m], vector)
    return worst, dot(inverse[2], vector), explained / chi


@kept_njit(error_model="numpy")
def false_reading(data, load, chi, free, noise, tests, found):  # type: ignore[no-untyped-def]
    """Return the verdict on a single reading, `SOUND`, `FALSE` or `ONE_OF_TWO`, and the reading (3 taxel + axis).

    ``tests``: excess, misfit, and what `unexplained` returns; ``found`` (2, 5) becomes the loads without it and without
    the next best one. Tried are the reading that explains most to first order, starting from ``load``, and those of
    the strongest taxel, starting from the load that fits the other taxels.
    """
    at, measured, scale, strain, layer, tie = data
    excess, misfit, most, hidden, worst, _ = tests
    asked = excess > 0 if noise > 0 else misfit > SLIGHT_MISFIT and free > FEW_FREE
    if not (asked and free > 1 and (most > 0.5 * chi or hidden > HIDES)):
        return SOUND, -1
    measured, scale, place, apart = measured.copy(), scale.copy(), np.empty((1, 5)), np.empty((1, 5))
    for m in range(5):
        apart[0, m] = load[m]
    least_squares((at[1:], measured[1:], scale[1:], strain, layer, tie), apart, STEPS)
    best, least, second = -1, np.inf, np.inf
    for turn in range(4):
        k = worst if turn == 0 else turn - 1
        i, axis = k // 3, k % 3
        was, by = measured[i, axis], scale[i, axis]
        if by == 0:
            continue
        for m in range(5):
            place[0, m] = load[m] if turn == 0 else apart[0, m]
        measured[i, axis] = scale[i, axis] = 0.0
        left, _ = least_squares((at, measured, scale, strain, layer, tie), place, STEPS)
        measured[i, axis], scale[i, axis] = was, by
        row = 0 if left < least else 1 if k != best and left < second else -1
        if row == 0 and k != best:
            second = least
            for m in range(5):
                found[1, m] = found[0, m]
        if row == 0:
            best, least = k, left
        elif row == 1:
            second = left
        for m in range(5):
            if row >= 0:
                found[row, m] = place[0, m]
    rest, one = max(free - 1, 0), noise * noise
    if noise > 0 and least <= one * (rest + 3 * math.sqrt(2.0 * rest)) and chi - least > FALSE_SIGMAS**2 * one:
        if free <= 1:
            return SOUND, best
        alone = second - least > FALSE_SIGMAS**2 * one
    elif free > FEW_FREE and least * FALSE_TIMES * free < chi * (free - 1):
        alone = least * FALSE_TIMES < second
    else:
        return SOUND, best
    if alone:
        return FALSE, best
    away = (found[0, 0] - found[1, 0]) ** 2 + (found[0, 1] - found[1, 1]) ** 2
    return ONE_OF_TWO if away > SAME * SAME else SOUND, best
