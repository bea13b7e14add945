"""The exact flow of one cell whose rate is piecewise linear in its own state and jumps at known places, compiled."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit


@kept_helper(error_model="numpy")
def rate_at(x, drive, a, places, jumps, closed, side):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return dx/dt right above x (``side`` 1), right below (-1), or at x itself (0), as the tables are closed."""
    rate = drive - x + a * min(max(x, -1.0), 1.0)
    for k in range(places.size):
        if places[k] > x or (places[k] == x and (side < 0 or (side == 0 and closed[k]))):
            rate += jumps[k]
    return rate


@kept_helper(error_model="numpy")
def place_ahead(x, ahead, places):  # type: ignore[no-untyped-def]
    """Return the nearest place beyond x at which the rate jumps or bends, infinity if there is none."""
    nearest = ahead * np.inf
    for k in range(-2, places.size):
        place = 2.0 * k + 3.0 if k < 0 else places[k]
        if ahead * (place - x) > 0 and ahead * (nearest - place) > 0:
            nearest = place
    return nearest


@kept_helper(error_model="numpy")
def from_jump_to_jump(x, drive, a, t, places, jumps, closed):  # type: ignore[no-untyped-def]
    """Return the state after a time, how much it moves if the start is moved, and whether the start is on a ridge.

    A cell that is driven back from both sides of a place stays there; a ridge drives it off to both sides.
    """
    above = rate_at(x, drive, a, places, jumps, closed, 1)
    below = rate_at(x, drive, a, places, jumps, closed, -1)
    if above <= 0 <= below:
        return x, 1.0, above == below and a > 1 and abs(x) < 1
    ridge = above > 0 > below
    start = rate_at(x, drive, a, places, jumps, closed, 0) if above * below <= 0 else above
    if start == 0:
        return x, 1.0, True
    ahead = 1.0 if start > 0 else -1.0
    while True:
        rate = rate_at(x, drive, a, places, jumps, closed, ahead) * ahead
        if rate <= 0:
            return x, 0.0, ridge
        slope = a - 1 if -1 < x < 1 or x == -ahead else -1.0
        place = place_ahead(x, ahead, places)
        away = abs(place - x)
        reaches = slope >= 0 or rate > -slope * away
        needed = np.inf
        if reaches:
            needed = away / rate if slope == 0 else math.log1p(slope * away / rate) / slope
        if needed > t or not reaches:
            moved = rate * t if slope == 0 else rate * math.expm1(slope * t) / slope
            return x + ahead * moved, rate * math.exp(slope * t) / abs(start), ridge
        x, t = place, t - needed


@kept_njit(error_model="numpy")
def flow_of_cells(x, drive, free, around, taps, steps, cell):  # type: ignore[no-untyped-def]
    """Write the states after a time over x (n, rows, cols); return the largest growth of a push, and the ridges.

    ``around``: the input with virtual cells; ``taps`` (places, 2): the neighbour of each place; ``steps`` (3, places):
    where its table jumps, by how much the drive does, and 1 if the edge itself belongs above; ``cell``: (a, time).
    """
    a, t = cell
    ridges = np.zeros(x.shape, np.bool_)
    growth = np.ones(x.shape)
    places = np.empty(taps.shape[0])
    closed = steps[2] > 0
    for g in range(x.shape[0]):
        for i in range(x.shape[1]):
            for j in range(x.shape[2]):
                if not free[g, i, j]:
                    continue
                for k in range(places.size):
                    places[k] = around[g, i + taps[k, 0], j + taps[k, 1]] - steps[0, k]
                found = from_jump_to_jump(x[g, i, j], drive[g, i, j], a, t, places, steps[1], closed)
                x[g, i, j], growth[g, i, j], ridges[g, i, j] = found
    return growth, ridges
