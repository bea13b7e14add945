"""Noise, compiled: robust spread of many short series, their smallest changes, and frames that are noise."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit

STRIKING = 6.0
"""Sigma above which a reading is no noise: one of 768 reaches it by chance in one frame of a million."""


@kept_njit(error_model="numpy")
def deviations(series, out):  # type: ignore[no-untyped-def]  # typed at the call
    """Write the median absolute deviation from the median of each row of ``series`` (m, n), sorted, to ``out`` (m,).

    NaN comes last and is left out; a row without numbers has 0. The deviations are taken in order, from the median
    outwards.
    """
    for row in range(series.shape[0]):
        a, n = series[row], series.shape[1]
        while n and math.isnan(a[n - 1]):
            n -= 1
        out[row] = 0.0
        if n:
            left, right = n // 2 - 1, n // 2
            middle = a[right] if n % 2 else (a[left] + a[right]) / 2
            before = last = 0.0
            for _ in range(n // 2 + 1):
                before = last
                if right == n or (left >= 0 and middle - a[left] < a[right] - middle):
                    last = middle - a[left]
                    left -= 1
                else:
                    last = a[right] - middle
                    right += 1
            out[row] = last if n % 2 else (before + last) / 2


@kept_njit(error_model="numpy")
def least_changes(frames, rounding, least):  # type: ignore[no-untyped-def]  # typed at the call
    """Lower ``least`` (m,) to the larger of the smallest changes up and down of the columns of ``frames`` (n, m).

    Changes up to the part ``rounding`` of the largest reading of a column do not count.
    """
    n, m = frames.shape
    most, up, down = np.zeros(m), np.full(m, np.inf), np.full(m, np.inf)
    for row in range(n):
        for k in range(m):
            if abs(frames[row, k]) > most[k]:  # NaN is not
                most[k] = abs(frames[row, k])
    for row in range(1, n):
        for k in range(m):
            change = frames[row, k] - frames[row - 1, k]
            if change > rounding * most[k] and change < up[k]:
                up[k] = change
            if -change > rounding * most[k] and -change < down[k]:
                down[k] = -change
    for k in range(m):
        least[k] = min(least[k], max(up[k], down[k]))


@kept_njit(error_model="numpy")
def is_within(values, most):  # type: ignore[no-untyped-def]  # typed at the call
    """Return whether no reading (rows, cols, 3) is larger than ``most``, and all are known."""
    within = True
    for value in values.flat:
        within = within and abs(value) <= most
    return within


@kept_njit(error_model="numpy")
def is_noise(values, per_sigma):  # type: ignore[no-untyped-def]  # typed at the call
    """Return whether readings are consistent with noise: none is extreme, and their total power is plausible.

    Arguments: ``values``; ``per_sigma``: 1 over the noise, 0 for ignored components; both (rows, cols, 3).
    """
    total = 0.0
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            for k in range(values.shape[2]):
                z = values[i, j, k] * per_sigma[i, j, k]
                if not abs(z) < STRIKING:
                    return False
                total += z * z
    return total < 1.3 * values.size + 6.5 * math.sqrt(2 * values.size)  # 6.5 sigma above a noise known to a seventh
