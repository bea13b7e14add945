"""One point load from one frame, compiled: taxel inverse, consensus of the taxels, least squares, tests of residuals.

The answer is given where one load explains all taxels and no test speaks against it, which is nearly every frame; else
`tactile.inverse.model_selection` compares models.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.fit_numba import fit, misfits, student
from tactile.inverse.limits import (
    DOUBT,
    EQUAL,
    FEW_FREE,
    FEWEST,
    LARGE_PAD,
    MISLED,
    NOISE_FROM,
    PEAK,
    RIVAL,
    SECOND_SHARE,
    SLIGHT_MISFIT,
    SMALL_SHARE,
    UNSURE,
    USUAL_NOISE,
    VOTERS,
)
from tactile.inverse.residual_tests_numba import (
    SOUND,
    false_reading,
    second_load,
    unexplained,
)
from tactile.inverse.start_numba import (
    consensus,
    layer_places,
    residuals_of_places,
    signals,
    strongest,
    two_best,
)
from tactile.inverse.taxel_numba import answers
from tactile.inverse.validity import Validity

DOUBTFUL, NOTHING, FOUND = 0, 1, 2
"""Results of `single_load`: the models must be compared; no taxel has a signal; the answer is filled in."""
INVALID = float(Validity.INVALID)


@kept_njit(error_model="numpy")
def one_load(at, planes, weights, order, units, noise):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return the places tried, best and next best of them, the signals, and the load (1, 5) with what `fit` returns.

    ``weights``: signal, trust and scale of the taxels; ``units``: depth, whether they measure strain, table of the
    layer, and the signal that counts as 1.
    """
    signal, trust, scale = weights
    depth, strain, layer, top = units
    tried = consensus(at, planes, signal, trust, order[:VOTERS], depth)
    first, second = two_best(tried)
    seen, measured, scaled, tie = signals(at, planes, scale, order, tried[first], depth, strain, top)
    some = seen[:VOTERS], measured[:VOTERS], scaled[:VOTERS], strain, layer, tie
    residuals_of_places(some, tried)
    if len(layer) > 0:
        tried = layer_places(some, tried, noise)
    first, second = two_best(tried)
    data, loads = (seen, measured, scaled, strain, layer, tie), np.zeros((1, 5))
    loads[0, 0], loads[0, 1] = tried[first, 0], tried[first, 1]
    return tried, first, second, data, loads, fit(data, loads, noise, True)


@kept_njit(error_model="numpy")
def single_load(  # type: ignore[no-untyped-def]  # typed at the call
    values, planes, at, scale, trust, times, depth, floor, strain, layer, noise, answer,
):  # fmt: skip
    """Fill ``answer`` (19 + n,) with a load and return `FOUND`: x, y [m], Q, R, F [N], their standard deviations, those
    from frame to frame, misfit, taxels, whether it is inside, and the taxels under it that cannot be read, their number
    first.

    ``values`` (rows, cols, 3) readings, or (rows, cols, 0) where ``planes`` (families, 4, n) of the inverse are given;
    ``at`` (n, 2) [m]; ``scale`` (n, 3) and ``trust`` (n,): see `Weights`; ``times``: scale of the inverse; ``depth``
    [m]; ``floor``; ``strain``: whether the taxels measure it; table of the ``layer``; ``noise`` [N], 0 where it is
    unknown.
    """
    rows, cols, _ = values.shape
    if values.size > 0:
        planes = answers(values, strain, times, depth, floor)
        if len(planes) == 0:
            return NOTHING
    signal, peak, order = strongest(planes, trust, depth, strain)
    if order.size < FEWEST:
        return DOUBTFUL
    top = peak[order[0]]
    one = noise / top
    known = depth, strain, layer, top
    tried, first, second, data, loads, fitted = one_load(at, planes, (signal, trust, scale), order, known, one)
    seen, measured, scaled, _, _, tie = data
    chi, whole, covariance, left, stranger = fitted
    free = measured.size - 5
    rivals = second != first and tried[second, 2] < RIVAL * tried[first, 2]
    if rivals or stranger >= 0 or tie[0] + tie[2] > 0:
        return DOUBTFUL
    if noise == 0 and len(seen) >= NOISE_FROM and chi >= SMALL_SHARE * whole:
        return DOUBTFUL
    _, excess, misfit = misfits(chi, whole, len(seen), free, one, 0.0)
    more, found = np.empty(5), np.empty((2, 5))
    most, hidden, worst, clipped = unexplained(data, loads[0], one, chi, excess, free, covariance, more)
    said, _ = false_reading(data, loads[0], chi, free, one, (excess, misfit, most, hidden, worst, clipped), found)
    dead, ends = equal_readings(measured, scaled)
    if said != SOUND or dead >= 0 or ends > 1 or misfit > DOUBT:
        return DOUBTFUL
    if clipped and (misfit > SLIGHT_MISFIT or excess > 0) and free > FEW_FREE:
        return DOUBTFUL
    if noise > 0 and excess > 0 and misfit > SLIGHT_MISFIT:
        _, force, share = second_load(data, loads[0], covariance, left)
        if force > 0 and share > SECOND_SHARE:
            return DOUBTFUL
    if min(rows, cols) > LARGE_PAD and np.abs(left).max() > max(PEAK / 2, 6 * math.sqrt(chi / free)):
        return DOUBTFUL
    deviation = math.sqrt(max(chi / free, one * one))
    for m in range(2):
        assumed = max(deviation, USUAL_NOISE) if noise == 0 else deviation
        if not max(assumed**2, deviation**2 + excess) * covariance[m, m] <= UNSURE**2:
            return DOUBTFUL
        if not deviation**2 * covariance[m, m] + more[m] <= MISLED**2:
            return DOUBTFUL
    deviation *= student(free) if noise == 0 else 1.0
    x, y, nearest = loads[0, 0], loads[0, 1], np.inf
    for i in range(len(seen)):
        nearest = min(nearest, (seen[i, 0] - x) ** 2 + (seen[i, 1] - y) ** 2)
    answer[0] = at[order[0], 0] + (x - seen[0, 0]) * depth
    answer[1] = at[order[0], 1] + (y - seen[0, 1]) * depth
    for k in range(5):
        unit = depth if k < 2 else top
        if k >= 2:
            answer[k] = loads[0, k] * top
        answer[10 + k] = deviation * math.sqrt(covariance[k, k]) * unit
        answer[5 + k] = math.sqrt(deviation**2 * covariance[k, k] + more[k]) * unit if more[k] > 0 else answer[10 + k]
    answer[15], answer[16], answer[17] = misfit, order.size, nearest < 2
    answer[18] = unread(at, planes, answer[0], answer[1], depth, answer[19:])
    return FOUND


@kept_njit(error_model="numpy")
def equal_readings(measured, scale):  # type: ignore[no-untyped-def]
    """Return the only reading (3 taxel + axis) that is zero, -1 for none, and how many are equally the largest.

    Noisy readings are never equal, so the first is dead and the others are clipped. Where any two others are equal, as
    with coarse steps or loads on an axis of symmetry, neither is: -1 and 0.
    """
    raw, largest, zero, zeros, count, ends = np.empty(measured.size), 0.0, -1, 0, 0, 0
    for i in range(len(measured)):
        for k in range(3):
            if scale[i, k] > 0:
                largest = max(largest, abs(measured[i, k]) / scale[i, k])
    for i in range(len(measured)):
        for k in range(3):
            own = abs(measured[i, k])
            if own >= largest * (1 - EQUAL) * scale[i, k] > 0:
                ends += 1
            elif scale[i, k] > 0 and own <= EQUAL * largest * scale[i, k]:
                zero, zeros = 3 * i + k, zeros + 1
            elif scale[i, k] > 0:
                raw[count] = own / scale[i, k]
                count += 1
    if zeros != 1 and ends < 2:
        return -1, 0
    for i in range(count):
        for j in range(i):
            if abs(raw[i] - raw[j]) <= EQUAL * max(raw[i], raw[j]):
                return -1, 0
    return zero if zeros == 1 and ends == 1 else -1, ends if ends > 1 else 0


@kept_njit(error_model="numpy")
def unread(at, planes, x, y, depth, cells):  # type: ignore[no-untyped-def]
    """Fill ``cells`` with the taxels, places ``at`` (n, 2) [m], that have no answer to a load inside at (x, y) [m].

    Return their number; ``planes`` (families, 4, n) as the inverse gives them.
    """
    count = 0
    for n in range(len(at)):
        answers_of = 0
        for f in range(len(planes)):
            answers_of += planes[f, 3, n] != INVALID
        if answers_of == 0 and (at[n, 0] - x) ** 2 + (at[n, 1] - y) ** 2 < 2 * depth * depth:
            cells[count] = n
            count += 1
    return count
