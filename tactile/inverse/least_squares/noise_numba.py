"""Noise that is read off what a fit leaves of many taxels, compiled, and what stands out of it."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

LOOSE = 12.0
"""Twice the error of a variance from a tenth's quantile of n numbers, times the root of n."""
HALF, TENTH = 0.6745, 0.1257
"""Quantiles of |x| for normal x of variance 1. What is left of a wide patch is no noise: where nothing presses the
signals themselves are not larger than the noise."""


@kept_njit(error_model="numpy")
def read_noise(rest, felt, cells, rows, cols, chi, chance):  # type: ignore[no-untyped-def]  # numba types it
    """Return the part of chi^2 that is noise, with what chance may add, from what is left (n, 3) of the signals (n, 3).

    What a taxel of the array leaves is no noise as far as it is like its neighbours': a smooth field's is, but for
    ``chance`` standard deviations.
    """
    raw, size = np.empty(rest.size), rest.size
    noise = np.inf
    for values, part, quantile in ((rest, 0.5, HALF), (felt, 0.1, TENTH)):
        for i in range(len(values)):
            for m in range(3):
                raw[3 * i + m] = abs(values[i, m])
        noise = min(noise, smallest(raw, int(part * size)) / quantile)
    place = np.full(rows * cols, -1)
    for i in range(len(cells)):
        place[cells[i]] = i
    alike = 0.0
    for k in range(rows * cols):
        i = place[k]
        if i < 0:
            continue
        for near, inside in ((k + 1, (k + 1) % cols != 0), (k + cols, k + cols < rows * cols)):
            if inside and place[near] >= 0:
                j = place[near]
                alike += rest[i, 0] * rest[j, 0] + rest[i, 1] * rest[j, 1] + rest[i, 2] * rest[j, 2]
    pairs = (rows - 1) * cols + rows * (cols - 1)
    likeness = min(max(alike / pairs * rows * cols / chi - chance / math.sqrt(3.0 * pairs), 0.0), 1.0)
    return min(noise * noise * (size + LOOSE * math.sqrt(size)), chi * (1 - likeness))


@kept_njit(error_model="numpy")
def stands_out(rest, worst, times):  # type: ignore[no-untyped-def]
    """Whether a taxel leaves more than so many times what the median taxel does, in squares."""
    squares = np.empty(len(rest))
    for i in range(len(rest)):
        squares[i] = rest[i, 0] ** 2 + rest[i, 1] ** 2 + rest[i, 2] ** 2
    own, half = squares[worst], len(rest) // 2
    upper = smallest(squares, half)
    if len(rest) % 2 == 0:
        upper = (upper + smallest(squares, half - 1)) / 2
    return own > times * upper


@kept_helper(error_model="numpy")
def smallest(numbers, k):  # type: ignore[no-untyped-def]
    """Return the k-th smallest number, from 0 on, and sort them so far: Hoare's way; NumPy's takes long to compile."""
    low, high = 0, len(numbers) - 1
    while low < high:
        pivot, i, j = numbers[k], low, high
        while i <= j:
            while numbers[i] < pivot:
                i += 1
            while pivot < numbers[j]:
                j -= 1
            if i <= j:
                numbers[i], numbers[j] = numbers[j], numbers[i]
                i += 1
                j -= 1
        if j < k:
            low = i
        if k < i:
            high = j
    return numbers[k]
