"""The exact transient of a linear template on a small grid: from kink to kink by Taylor series, and by DOP853.

Within one pattern of saturated cells the network is linear, x' = J x + c (Chua and Yang 1988, eq. 2), and a short piece
of its flow is a Taylor series of 26 terms. The series of all cells show which cell is the first to meet -1 or +1;
there a new series begins. Cells are coupled one by one, by the definition of the boundary.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cnnsim.support import Floats

TERMS = 26
LOOKS = 16
"""Times within a series at which the distances to the kinks are evaluated."""
ROUNDING = 4e-15


def coupling(A: Floats, shape: tuple[int, int], boundary: Any) -> tuple[Floats, Floats]:
    """The matrix (cells, cells) of A, and what virtual cells of constant output drive."""
    rows, cols = shape
    matrix, constant, r = np.zeros((rows * cols, rows * cols)), np.zeros(rows * cols), len(A) // 2
    for i in range(rows):
        for j in range(cols):
            for k in range(-r, r + 1):
                for l in range(-r, r + 1):
                    p, q, weight = i + k, j + l, A[k + r, l + r]
                    if boundary.kind == "periodic":
                        p, q = p % rows, q % cols
                    elif boundary.kind == "zero-flux":
                        p, q = min(max(p, 0), rows - 1), min(max(q, 0), cols - 1)
                    if 0 <= p < rows and 0 <= q < cols:
                        matrix[i * cols + j, p * cols + q] += weight
                    else:
                        constant[i * cols + j] += weight * boundary.y
    return matrix, constant


def exact(
    A: Floats, w: Floats, x0: Floats, boundary: Any, duration: float, mask: Any = None, *, limited: bool = False
) -> Floats:
    """The state at ``duration``; w is the drive B*u + z of each cell; ``limited``: full-range cells."""
    matrix, constant = coupling(np.asarray(A, float), x0.shape, boundary)
    drive = constant + w.ravel()
    free = np.ones(x0.size, bool) if mask is None else ~np.asarray(mask, bool).ravel()
    x, left = x0.ravel().astype(float), duration
    outwards = np.sign(x) * (matrix @ x.clip(-1, 1) + drive - x) >= 0
    piece = np.where((np.abs(x) > 1) | ((np.abs(x) == 1) & (outwards | ~free)), np.sign(x), 0.0)
    longest = 1.0 / (1.0 + np.abs(matrix).sum(axis=1).max())
    while left > 0:
        s = min(left, longest)
        moves = free & ((piece == 0) | (not limited))
        series = np.zeros((TERMS, x.size))
        series[0], series[1] = x, moves * (matrix @ np.where(piece == 0, x, piece) + drive - x)
        for k in range(1, TERMS - 1):
            series[k + 1] = moves * (matrix @ np.where(piece == 0, series[k], 0.0) - series[k]) / (k + 1)
        t, cells = _first_kink(_gaps(series, piece, matrix, drive, limited=limited), free, s)
        x = series.T @ t ** np.arange(TERMS)
        for i, side in cells:
            piece[i], x[i] = (0.0, piece[i]) if piece[i] else (side, side)
        left = 0.0 if left - t < 1e-14 * duration else left - t
    return x.reshape(x0.shape)


def _gaps(series: Floats, piece: Floats, matrix: Floats, drive: Floats, *, limited: bool) -> Floats:
    """Polynomials (2, terms, cells) of the distance to the upper and lower kink, or of the rate that holds a cell."""
    below, above = -series, series.copy()
    below[0] += 1
    above[0] += 1
    stays = series * piece
    stays[0] -= 1
    if limited:
        outputs = np.where(piece == 0, series, 0.0)
        outputs[0] += piece
        stays = outputs @ matrix.T - series
        stays[0] += drive
        stays *= piece
    return np.stack([np.where(piece == 0, below, stays), np.where(piece == 0, above, 1.0)])


def _first_kink(gaps: Floats, free: Any, s: float) -> tuple[float, list[tuple[int, float]]]:
    """The first time up to s at which a distance becomes negative, and the (cell, side) that it belongs to."""
    terms = gaps.transpose(1, 0, 2).reshape(TERMS, -1)
    slopes = terms[1:] * np.arange(1, TERMS)[:, None]
    bends = slopes[1:] * np.arange(1, TERMS - 1)[:, None]
    times = s * np.arange(LOOKS + 1) / LOOKS

    def value(c: Floats, t: Any, of: Any = slice(None)) -> Floats:
        found = np.zeros_like(c[0][of])
        for row in c[::-1]:
            found = found * t + row[of]
        return found

    moving = np.tile(free, 2)
    for low, high in pairwise(times):
        negative = moving & (value(terms, high) < -ROUNDING)
        turns = moving & ~negative & (value(slopes, low) < 0) & (value(slopes, high) > 0)
        ends = np.full(moving.size, high)
        for n in np.flatnonzero(turns):  # it may be negative in between: the minimum by Newton's method
            t = 0.5 * (low + high)
            for _ in range(6):
                t = float(np.clip(t - value(slopes, t, n) / (value(bends, t, n) or 1.0), low, high))
            negative[n], ends[n] = value(terms, t, n) < -ROUNDING, t
        of = np.flatnonzero(negative)
        if of.size:
            left, right = np.full(of.size, low), ends[of]
            for _ in range(70):
                middle = 0.5 * (left + right)
                below = value(terms, middle, of) < 0
                left, right = np.where(below, left, middle), np.where(below, middle, right)
            t = float(right.min())
            found = of[right <= t + 1e-15]
            return t, [(int(n % free.size), 1.0 if n < free.size else -1.0) for n in found]
    return s, []


def by_scipy(A: Floats, w: Floats, x0: Floats, boundary: Any, duration: float) -> Floats:
    """The same by DOP853 with the tightest tolerance, which sees the kinks as any other bend."""
    matrix, constant = coupling(A, x0.shape, boundary)
    drive = constant + w.ravel()
    found = solve_ivp(
        lambda _t, x: matrix @ x.clip(-1, 1) + drive - x, (0.0, duration), x0.ravel(), method="DOP853",
        rtol=1e-13, atol=1e-14, max_step=0.02,
    )  # fmt: skip
    return found.y[:, -1].reshape(x0.shape)
