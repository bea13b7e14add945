"""What speaks against a fit of one point load, compiled: signals far from it, and readings that are cut off.

Lengths and signals as in `half_space_numba`.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.equations_numba import equations, slopes
from tactile.inverse.least_squares.fit_numba import solve
from tactile.inverse.validity import Validity

INVALID = float(Validity.INVALID)


@kept_njit(error_model="numpy")
def foreign(at, left, felt, loads, reach, least, times):  # type: ignore[no-untyped-def]
    """Return the taxel where most is left, of those out of ``reach`` of all loads where it is ``least`` or more and
    ``times`` what is explained; -1 where there is none.
    """
    worst, largest = -1, least * least
    for i in range(len(left)):
        size = made = 0.0
        for k in range(3):
            size += left[i, k] ** 2
            made += (felt[i, k] - left[i, k]) ** 2
        if size > largest and size > times * times * made:
            nearest = np.inf
            for k in range(len(loads)):
                nearest = min(nearest, (at[i, 0] - loads[k, 0]) ** 2 + (at[i, 1] - loads[k, 1]) ** 2)
            if nearest > reach * reach:
                worst, largest = i, size
    return worst


@kept_njit(error_model="numpy")
def unread(at, planes, x, y, depth, cells):  # type: ignore[no-untyped-def]
    """Fill ``cells`` with the taxels, places ``at`` (n, 2) [m], that have no answer to a load inside at (x, y) [m].

    Return how many; ``planes`` (families, 4, n) as the inverse gives them.
    """
    count = 0
    for n in range(len(at)):
        answers = 0
        for f in range(len(planes)):
            answers += planes[f, 3, n] != INVALID
        if answers == 0 and (at[n, 0] - x) ** 2 + (at[n, 1] - y) ** 2 < 2 * depth * depth:
            cells[count] = n
            count += 1
    return count


@kept_njit(error_model="numpy")
def alike_at_end(felt, scale, near):  # type: ignore[no-untyped-def]
    """Return how many readings are the largest, but for a part ``near``, where no two others are alike; else 0.

    Noisy readings are alike at the end of their range alone; a load amid the taxels of a pad without noise makes all
    its readings alike in pairs, and so do coarse steps.
    """
    raw, count = np.empty(felt.size), 0
    for i in range(len(felt)):
        for m in range(3):
            if scale[i, m] > 0 and felt[i, m] != 0:
                raw[count] = abs(felt[i, m]) / scale[i, m]
                count += 1
    raw = raw[:count]
    if count == 0:
        return 0
    end, alike = raw.max() * (1 - near), 0
    for k in range(count):
        alike += raw[k] >= end
    if alike < 2:
        return 0
    _sort(raw)
    for k in range(count - alike - 1):
        if raw[k] >= raw[k + 1] * (1 - near):
            return 0
    return alike


@kept_helper(error_model="numpy")
def _sort(numbers):  # type: ignore[no-untyped-def]
    """Sort in place, by Shell's method: NumPy's takes seconds to compile."""
    gap = len(numbers) // 2
    while gap > 0:
        for i in range(gap, len(numbers)):
            own, k = numbers[i], i
            while k >= gap and numbers[k - gap] > own:
                numbers[k] = numbers[k - gap]
                k -= gap
            numbers[k] = own
        gap //= 2


@kept_njit(error_model="numpy")
def reads_nothing(felt, scale, near):  # type: ignore[no-untyped-def]
    """Return the only reading (3 taxel + axis) that is nothing, but for a part ``near`` of the largest; -1 if none is.

    -1 too where two others are alike: a load that lies on a line with taxels makes such readings, and so do coarse
    steps.
    """
    largest, lone, count = 0.0, -1, 0
    for i in range(len(felt)):
        for m in range(3):
            largest = max(largest, abs(felt[i, m]))
    for i in range(len(felt)):
        for m in range(3):
            if abs(felt[i, m]) <= near * largest and scale[i, m] > 0:
                lone, count = 3 * i + m, count + 1
    if count != 1:
        return -1
    raw, count = np.empty(felt.size), 0
    for i in range(len(felt)):
        for m in range(3):
            if scale[i, m] > 0 and 3 * i + m != lone:
                raw[count] = abs(felt[i, m]) / scale[i, m]
                count += 1
    raw = raw[:count]
    _sort(raw)
    for k in range(count - 1):
        if raw[k] >= raw[k + 1] * (1 - near):
            return -1
    return lone


@kept_njit(error_model="numpy")
def without_largest(at, felt, scale, load, strain, layer, tie, near):  # type: ignore[no-untyped-def]
    """Return chi^2 without the largest reading and by how many times it would then be larger, and how many are so near.

    To first order: what a reading leaves, r^2, is r^2 / (1 - h) of chi^2, where h = J (J^T J)^-1 J^T of its slopes J.
    """
    worst, k, largest = 0, 0, -1.0
    for i in range(len(at)):
        for m in range(3):
            if scale[i, m] > 0 and abs(felt[i, m]) > largest * scale[i, m]:
                worst, k, largest = i, m, abs(felt[i, m]) / scale[i, m]
    count = 0
    for i in range(len(at)):
        for m in range(3):
            if scale[i, m] > 0 and abs(felt[i, m]) >= largest * scale[i, m] * (1 - near):
                count += 1
    matrix, vector, step, factor = np.empty((5, 5)), np.empty(5), np.empty(5), np.empty((5, 5))
    chi = equations(at, felt, scale, load.reshape((1, 5)), strain, layer, matrix, vector)
    matrix[2, 2] += tie[0]
    matrix[3, 2] += tie[1]
    matrix[3, 3] += tie[2]
    left, along, one = np.zeros((3, 1)), np.empty((5, 3, 1)), slice(worst, worst + 1)
    slopes(at[one], scale[one], load, strain, layer, left, along)
    for m in range(5):
        vector[m] = along[m, k, 0]
    if not solve(matrix, vector, 0.0, factor, step):
        return chi, 1.0, count
    share = 0.0
    for m in range(5):
        share += vector[m] * step[m]
    off = felt[worst, k] + left[k, 0]
    free = max(1 - share, 1e-9)
    return max(chi - off * off / free, 0.0), 1 - off / free / felt[worst, k], count


@kept_njit(error_model="numpy")
def may_be_cut(chi, noise, without, beyond, count, hint, told):  # type: ignore[no-untyped-def]
    """Whether a fit without the largest reading is worth its time, from what `without_largest` says of it.

    chi^2 has to be ``hint`` times less or, where the noise is known, less by ``told`` deviations squared; to first
    order by half of that.
    """
    if count != 1:
        return True
    return beyond >= 1 and (without * hint <= chi or 0 < told * told * noise * noise < 2 * (chi - without))
