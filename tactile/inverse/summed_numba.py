"""Sums over the taxels of an array, compiled: the loop of `tactile.inverse.summed`, which has the formulas."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit


@kept_njit(error_model="numpy")
def sums(positions, values, valid, floor):  # type: ignore[no-untyped-def]  # typed at the call
    """Return (x, y, Q, R, F, M, pressed taxels, taxels that read)."""
    rows, cols = valid.shape
    q = r = f = weight = x = y = about = 0.0
    pressed = read = 0
    for i in range(rows):
        for j in range(cols):
            a, b, n = values[i, j, 0], values[i, j, 1], values[i, j, 2]
            if not valid[i, j] or not math.isfinite(a + b + n):
                continue
            read += 1
            q, r, f = q + a, r + b, f + n
            about += positions[i, j, 0] * b - positions[i, j, 1] * a
            if n > floor:
                pressed += 1
                weight += n
                x += n * positions[i, j, 0]
                y += n * positions[i, j, 1]
    if pressed == 0 or f <= floor:
        return np.nan, np.nan, q, r, f, np.nan, 0, read
    x, y = x / weight, y / weight
    return x, y, q, r, f, about - (x * r - y * q), pressed, read
