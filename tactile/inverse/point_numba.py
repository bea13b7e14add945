"""One point load from a frame at one go, compiled: the taxels' inverse, their consensus, the fit, and all doubts.

It answers where one load explains all taxels and nothing speaks against it, which is nearly every frame; where any of
that is in doubt it says so, and `tactile.inverse.localise` goes its long way.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.attempt_numba import one_load
from tactile.inverse.consensus_numba import strongest
from tactile.inverse.doubted_numba import holds, may_be_another
from tactile.inverse.least_squares.doubt_numba import alike_at_end, may_be_cut, reads_nothing, unread, without_largest
from tactile.inverse.least_squares.equations_numba import rest
from tactile.inverse.least_squares.false_reading_numba import NONE, false_reading, may_be_false, verdict
from tactile.inverse.least_squares.noise_numba import read_noise, stands_out
from tactile.inverse.least_squares.reliability_numba import unexplained
from tactile.inverse.least_squares.second_numba import second_load
from tactile.inverse.least_squares.student_numba import few
from tactile.inverse.planes_numba import answers

NOT_SIMPLE, NOTHING, FOUND = 0, 1, 2
"""What `one_point` says: go the long way; no taxel feels anything; the answer is filled in."""


@kept_njit(error_model="numpy")
def one_point(  # type: ignore[no-untyped-def]  # numba types it
    values, planes, at, scale, trust, strain, layer, numbers, noise, of_attempt, of_fit, limits, of_clipped, of_second,
    answer,
):  # fmt: skip
    """Fill ``answer`` (19 + n,) with a load and return `FOUND`: x, y [m], Q, R, F [N], their standard deviations, those
    from frame to frame, misfit, taxels, whether it is inside, how many taxels under it cannot be read, and which.

    ``values`` (rows, cols, 3), or (rows, cols, 0) where ``planes`` (families, 4, n) are given, as the inverse makes
    them; ``numbers``: its scale, depth [m] and floor; ``at`` (n, 2) [m]; ``layer``: table of `layer_field`; ``scale``,
    ``trust`` and ``noise`` [N] (0 where none is known) as `Weights`; ``of_attempt``: voters, seeds, steps, reach;
    ``of_fit``: the least a stranger feels, in parts and in standard deviations, how many times what the loads make
    there and in squares what the median taxel leaves, standard deviations that are chance and those that surely are
    not, share of the energy below which nobody asks for noise, noise where none is known, from how many taxels on it
    is asked for;
    ``limits``: taxels at least, and from how many on those near the load are fitted, how much worse a rival fits, how
    unsure a place may be, the misfit from which on a clipped reading may be to blame, and anything; ``of_clipped``:
    degrees of freedom that tell nothing of it, how near to the largest reading others are clipped too, how many times
    less has to be left without it or less by how many standard deviations squared, how near to each other readings are
    the same;
    ``of_second``: taxels from which on a second load is told, how far from the first, the part that it explains.
    """
    voters, seeds, steps, reach = of_attempt
    foreign_part, foreign_sigmas, foreign_times, foreign_median, chance, surely_none, small, usual, many = of_fit
    fewest, most, rival_times, unsure, slight, doubtful = limits
    least_free, near_end, hint, told, alike = of_clipped
    two, beside, hinted = of_second
    rows, cols, _ = values.shape
    times, depth, floor = numbers
    if values.size > 0:
        planes = answers(values, strain, times, depth, floor)
        if len(planes) == 0:
            return NOTHING
    signal, peak, order = strongest(planes, trust, depth, strain, voters)
    if order.size < fewest:
        return NOT_SIMPLE
    top = peak[order[0]]
    one = noise / top
    tried, first, second, seen, felt, scaled, tie, loads, chi, whole, spread, stranger = one_load(
        at, planes, signal, trust, scale, order, depth, strain, layer, top, one, voters, seeds, steps, reach,
        max(foreign_part, foreign_sigmas * one), foreign_times, most, many,
    )  # fmt: skip
    rivals = second != first and tried[second, 2] < rival_times * tried[first, 2]
    if tie[0] > 0 or tie[2] > 0 or rivals:
        return NOT_SIMPLE
    remains = rest(seen, felt, scaled, loads, strain, layer)
    if stranger >= 0 and stands_out(remains, stranger, foreign_median):
        return NOT_SIMPLE
    free = felt.size - len(loads[0])
    left, random, excess = chi / free, 0.0, 0.0
    if noise > 0:
        random = one * one * (free + chance * math.sqrt(2.0 * free))
        excess = max(chi - one * one * (free + surely_none * math.sqrt(2.0 * free)), 0.0)
        variance = left if left > one * one else one * one
    else:
        variance = left
        if not (chi < small * whole or len(seen) < many):
            random = read_noise(remains, felt, order, rows, cols, chi, chance)
            excess = max(chi - random, 0.0) if random > 0 else 0.0
    if may_be_another(remains, at, rows, cols, depth, chi, free):
        return NOT_SIMPLE
    energy = max(whole - random, random / len(seen))
    misfit = math.sqrt(min(max(chi - random, 0.0) / energy, 1.0)) if energy > 0 else 0.0
    deviation = math.sqrt(variance)
    doubt = max(deviation, usual) if noise == 0 else deviation
    more = np.empty(5)
    explains, taken, worst = unexplained(
        seen, felt, scaled, loads[0], strain, layer, tie, one, chi, excess, free, spread[0], steps, more
    )
    if may_be_false(chi, excess, free, one, misfit, explains, taken):
        found = np.empty((2, 5))
        k, without, next_best = false_reading(
            seen, felt, scaled, loads[0], strain, layer, tie, chi, steps, worst, found
        )
        if k >= 0 and verdict(chi, without, next_best, free, one, found) != NONE:
            return NOT_SIMPLE
    if noise > 0 and excess > 0 and misfit > slight and len(seen) >= two:
        _, force, part = second_load(seen, felt, scaled, loads[0], strain, layer, tie, beside)
        if force > 0 and part > hinted:
            return NOT_SIMPLE
    if reads_nothing(felt, scaled, alike) >= 0 or alike_at_end(felt, scaled, alike) > 1:
        return NOT_SIMPLE
    if (misfit > slight or excess > 0) and free > least_free:
        without, beyond, cut = without_largest(seen, felt, scaled, loads[0], strain, layer, tie, near_end)
        if may_be_cut(chi, one, without, beyond, cut, hint, told):
            return NOT_SIMPLE
    if not doubt * math.sqrt(max(spread[0, 0], spread[0, 1])) <= unsure:
        return NOT_SIMPLE
    if misfit > doubtful and not holds(
        seen, felt, scaled, tie, loads, chi, misfit, remains, tried, first, at, planes, scale, order, depth, strain,
        layer, top, steps, reach, most, many, noise > 0,
    ):  # fmt: skip
        return NOT_SIMPLE
    if noise == 0:
        deviation *= few(free)
    if deviation * deviation * spread[0, 0] + more[0] > unsure * unsure:
        return NOT_SIMPLE
    if deviation * deviation * spread[0, 1] + more[1] > unsure * unsure:
        return NOT_SIMPLE
    x, y, nearest = loads[0, 0], loads[0, 1], np.inf
    for i in range(len(seen)):
        dx, dy = seen[i, 0] - x, seen[i, 1] - y
        nearest = min(nearest, dx * dx + dy * dy)
    answer[0] = at[order[0], 0] + (x - seen[0, 0]) * depth
    answer[1] = at[order[0], 1] + (y - seen[0, 1]) * depth
    for k in range(5):
        unit = depth if k < 2 else top
        if k >= 2:
            answer[k] = loads[0, k] * top
        answer[5 + k] = answer[10 + k] = deviation * math.sqrt(spread[0, k]) * unit
        if more[k] > 0:
            answer[5 + k] = math.sqrt(deviation * deviation * spread[0, k] + more[k]) * unit
    answer[15], answer[16], answer[17] = misfit, order.size, nearest < 2
    answer[18] = 0 if order.size == len(at) else unread(at, planes, answer[0], answer[1], depth, answer[19:])
    return FOUND
