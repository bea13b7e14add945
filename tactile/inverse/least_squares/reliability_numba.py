"""How far a load may be off for what it leaves unexplained, compiled: one error in all signals, or one false reading.

Noise is independent from signal to signal; a thin cover, a wide tip or another load is not: more taxels feel more of
the same. What is left beyond the noise therefore counts once, not once for each degree of freedom, as if the part of it
that the load has taken for its own were as large as the part that is seen. Of a reading that the load hangs on little
is seen when it is false: it counts for as much as would hide so, and so does a width of the load (`width_numba`).

Of all readings of the strongest taxels some error always explains something, so much has to speak for it. There is but
one largest reading, it is cut off to one side, and by no more than itself; there is one width, it is none below zero
and no more than a depth: less has to. A dead channel reads noise: where a reading is no more and the others let it be
much, chance seldom has it. A reading that is turned round has no size to choose: where the load fits as well with the
opposite sign, both are possible, and how far they are apart counts.
Lengths and signals as in `half_space_numba`.

Sources: R. T. Birge, Phys. Rev. 40 (1932) 207; W. Baarda, A testing procedure for use in geodetic networks (1968);
J. G. MacKinnon, H. White, J. Econometrics 29 (1985) 305: the shifts squared are their third estimate; R. E. Kass, A. E.
Raftery, J. Am. Stat. Assoc. 90 (1995) 773: Bayes factors.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.equations_numba import equations, slopes
from tactile.inverse.least_squares.fit import HUNG_ON
from tactile.inverse.least_squares.fit_numba import back, factored, fit
from tactile.inverse.least_squares.width_numba import width

STRONGEST = 4
"""Of that many of the strongest taxels each reading is asked: no place hangs on one of the others."""
HIDDEN = 1e-6
"""The part of an error in a reading that is seen at least: less is rounding."""
NOTICED = 3.5
"""A reading counts as false from so many standard deviations on: chance does that in one of 200 frames, ..."""
BY_CHANCE = 0.02
"""... or, where nobody knows the noise, where chance would make one of them fit so badly in that part of all frames."""
LIKELY = 0.5
"""The largest reading counts as cut off, a load as wide, and any of the readings asked as dead, each of them so much
less, if that is so many times as likely as that it is not."""
WIDEST = 1.6
"""Largest width that is likely, over that of the ring of `width`: a ball's contact of one depth."""
AS_WELL = 1.0
"""A load with one reading turned round fits as well if chi^2 is larger by so many variances at most, ..."""
ANOTHER = 3.0
"""... and is another one if one of its numbers is so many deviations off."""
BENT = 50.0
"""To first order chi^2 may be larger by so many variances, where the other load is far away."""


@kept_njit(error_model="numpy")
def unexplained(  # type: ignore[no-untyped-def]
    at, felt, scale, load, strain, layer, tie, noise, chi, excess, free, spread, steps, more
):
    """Fill ``more`` (5,): variances of a load beyond those of noise, for what it leaves unexplained.

    Return the most that one reading explains of chi^2, the largest part of an error in one that the load hides, and
    which reading (3 taxel + axis) explains most. ``noise``: 0 where nobody knows it; ``excess``: the part of chi^2 that
    is no noise; ``steps`` of fits.
    """
    for m in range(5):
        more[m] = excess * spread[m]
    work = np.empty((14, 5))
    factor, vector, half, step = work[:5], work[5], work[6], work[7]
    if free < 2 or not normal(at, felt, scale, load, strain, layer, tie, work[9:], vector, factor):
        return 0.0, 0.0, 0
    count = min(len(at), STRONGEST)
    least, variance = NOTICED * NOTICED * noise * noise, noise * noise
    if noise == 0:
        least = chi * (1 - (BY_CHANCE / (3 * count + 1)) ** (2.0 / (free - 1)))
        variance = chi / free
    left, along = np.zeros((3, count)), np.empty((5, 3, count))
    slopes(at[:count], scale[:count], load, strain, layer, left, along)
    over, largest = work[8], 0.0
    for m in range(5):
        over[m] = 1 / factor[m, m]
    for i in range(count):
        for k in range(3):
            if scale[i, k] > 0:
                largest = max(largest, abs(felt[i, k]) / scale[i, k])
    most, taken, worst, of_many = -1.0, 0.0, 0, 2 * math.log(LIKELY * 3 * count)
    loose = max(spread[0], spread[1])
    for i in range(count):
        for k in range(3):
            for m in range(5):
                vector[m] = along[m, k, i]
            share, read = taken_by(factor, over, vector, half), felt[i, k]
            seen, off = max(1 - share, HIDDEN), read + left[k, i]
            explained, taken = off * off / seen, max(taken, share)
            if explained > most:
                most, worst = explained, 3 * i + k
            cut = off * read < 0 and abs(read) >= largest * scale[i, k]
            dead = explained - read * read > variance * (math.log(seen) + of_many)
            if (
                dead
                or explained > least
                or (cut and as_likely(explained, read * read * seen, variance, noise, chi, free))
            ):
                back(factor, vector, step)
                for m in range(5):
                    more[m] += step[m] ** 2 * (explained + variance) / seen
            moved = 4 * read * read * share  # in deviations of any of the five numbers no more
            if moved > ANOTHER * ANOTHER * variance:
                bent = 2 * read * moved * loose  # what the square of the way may change of the signals
                bent = min(bent * bent, BENT * variance)
                if 4 * read * (read * seen - off) < AS_WELL * variance + bent:
                    one = 3 * i + k
                    _add_turned(at, felt, scale, load, strain, layer, tie, chi, variance, spread, steps, one, more)
    if noise == 0 or taken > HUNG_ON or chi > noise * noise * (free + math.sqrt(2.0 * free)):
        along_it, seen = width(at, felt, scale, load, strain, layer, tie, factor, step)
        explained = along_it * along_it / seen if seen > 0 else 0.0
        wide = along_it > 0 and as_likely(explained, WIDEST * WIDEST * seen, variance, noise, chi, free)
        if explained > least or wide:
            for m in range(5):
                more[m] += step[m] ** 2 * (explained + variance) / seen
    return most, taken, worst


@kept_helper(error_model="numpy")
def as_likely(explained, range_seen, variance, noise, chi, free):  # type: ignore[no-untyped-def]
    """Whether an error that explains so much of chi^2 is as likely as none, but for a factor `LIKELY`: Bayes's factor.

    Before anything is read any size up to its range is alike likely, whose square is seen as ``range_seen`` of chi^2.
    """
    times = explained / variance if noise > 0 else -free * math.log(1 - min(explained / chi, 1 - HIDDEN))
    return times - math.log(max(range_seen / (2 * math.pi * variance), 1.0)) > 2 * math.log(LIKELY)


@kept_helper(error_model="numpy")
def _add_turned(  # type: ignore[no-untyped-def]
    at, felt, scale, load, strain, layer, tie, chi, variance, spread, steps, reading, more
):
    """Add to ``more`` how far the load is off if that reading is turned round, where that is another load that fits."""
    turned, other = felt.copy(), np.empty((1, 5))
    turned[reading // 3, reading % 3] *= -1
    for m in range(5):
        other[0, m] = load[m]
    left, _, _ = fit(at, turned, scale, other, strain, layer, tie, steps)
    if left > chi + AS_WELL * variance:
        return
    is_another = False
    for m in range(5):
        is_another |= (other[0, m] - load[m]) ** 2 > ANOTHER * ANOTHER * variance * spread[m]
    if is_another:
        for m in range(5):
            more[m] += (other[0, m] - load[m]) ** 2


@kept_njit(error_model="numpy")
def normal(at, felt, scale, load, strain, layer, tie, matrix, vector, factor):  # type: ignore[no-untyped-def]
    """Fill the normal matrix (5, 5) of one load and its factor of Cholesky; False where it is not definite."""
    equations(at, felt, scale, load.reshape((1, 5)), strain, layer, matrix, vector)
    matrix[2, 2] += tie[0]
    matrix[3, 2] += tie[1]
    matrix[3, 3] += tie[2]
    return factored(matrix, 0.0, factor)


@kept_helper(error_model="numpy")
def taken_by(factor, over, along, half):  # type: ignore[no-untyped-def]
    """Return h = J^T C J of a reading's slopes J, the part of an error in it that the load takes for its own.

    ``over`` (5,): 1 over the diagonal of the factor.
    """
    share = 0.0
    for m in range(5):
        total = along[m]
        for k in range(m):
            total -= factor[m, k] * half[k]
        half[m] = total * over[m]
        share += half[m] * half[m]
    return share
