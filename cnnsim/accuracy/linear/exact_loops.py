"""From kink to kink, compiled: the Taylor series about now, the first kink in it, and the state there (`exact_flow`).

Coefficients are (terms, cells); a cell's ``piece`` is 0 where it is linear, else the output at which it is saturated.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

TERMS = 26
"""Of the series, at most. With |J| s <= 2 the first one left out is 2^26 / 26! = 2e-19 of the state."""
LEAN_TERMS = 6
"""Of the series of a push, which is wanted to a tenth of itself."""
LEFT_OUT = 1e-18
"""A term below this part of the state is the last one."""
LOOK_AHEAD = 2.0
"""Times the usual time between two kinks that a series is made for: what lies beyond the next kink is thrown away."""
PARTS = 8
"""Of a series' time, in each of which a gap is looked at."""
TOUCH = 2e-15
"""A cell that passes its kink by less, and comes back, has not passed it."""
TOGETHER = 1e-14
"""Kinks that are no farther apart in time are one."""


@kept_helper(error_model="numpy")
def value(c, t):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return a polynomial's value."""
    total = 0.0
    for k in range(c.size - 1, -1, -1):
        total = total * t + c[k]
    return total


@kept_helper(error_model="numpy")
def slope(c, t):  # type: ignore[no-untyped-def]
    """Return a polynomial's derivative."""
    total = 0.0
    for k in range(c.size - 1, 0, -1):
        total = total * t + k * c[k]
    return total


@kept_helper(error_model="numpy")
def turn(c, low, high):  # type: ignore[no-untyped-def]
    """Return where between two times a polynomial whose slopes have two signs there turns round."""
    sign = slope(c, low)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if slope(c, middle) * sign > 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kept_helper(error_model="numpy")
def root(c, low, high):  # type: ignore[no-untyped-def]
    """Return where a polynomial that is positive at ``low`` and negative at ``high`` is 0: Newton within halves."""
    t = 0.5 * (low + high)
    for _ in range(100):
        v = value(c, t)
        if v > 0:
            low = t
        else:
            high = t
        d = slope(c, t)
        after = t - v / d if d != 0 else low
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - t) <= 1e-17 + 1e-16 * t:
            return after
        t = after
    return t


@kept_helper(error_model="numpy")
def crossing(c, s):  # type: ignore[no-untyped-def]
    """Return the first time in (0, s] at which a gap becomes negative, 2 s if it does not; also between two looks."""
    step = s / PARTS
    bend, power = 0.0, 1.0
    for k in range(2, c.size):
        bend += k * (k - 1) * abs(c[k]) * power
        power *= s
    depth = bend * step * step / 8
    t, before = 0.0, c[0]
    for part in range(1, PARTS + 1):
        low, t = t, s * part / PARTS
        v = value(c, t)
        high = t
        if v >= -TOUCH:
            shallow = before > 0 and min(before, v) < depth
            if not (shallow and slope(c, low) < 0 and slope(c, t) > 0):
                before = v
                continue
            high = turn(c, low, t)
            if value(c, high) >= -TOUCH:
                before = v
                continue
        if before <= 0:  # it stands on the kink: it passes at once, or rises and comes back
            if slope(c, low) <= 0:
                return low
            low = turn(c, low, high)
        return root(c, low, high)
    return 2 * s


@kept_helper(error_model="numpy")
def series_of(at, there, weight, drive, free, limited, piece, x, push, s, series, lean):  # type: ignore[no-untyped-def]
    """Write the Taylor coefficients of state and push about now; return how many."""
    cells = x.size
    size = 1.0
    for i in range(cells):
        series[0, i], lean[0, i] = x[i], push[i]
        moves = free[i] and not (limited and piece[i] != 0)
        total = drive[i] - x[i]
        moved = -push[i]
        for n in range(at[i], at[i + 1]):
            j = there[n]
            total += weight[n] * (x[j] if piece[j] == 0 else piece[j])
            moved += weight[n] * push[j] if piece[j] == 0 else 0.0
        series[1, i], lean[1, i] = (total, moved) if moves else (0.0, 0.0)
        size = max(size, abs(x[i]))
    power = s
    for k in range(1, TERMS - 1):
        most = 0.0
        for i in range(cells):
            if not free[i] or (limited and piece[i] != 0):
                series[k + 1, i] = 0.0
                if k + 1 < LEAN_TERMS:
                    lean[k + 1, i] = 0.0
                continue
            total = -series[k, i]
            for n in range(at[i], at[i + 1]):
                j = there[n]
                if piece[j] == 0:
                    total += weight[n] * series[k, j]
            series[k + 1, i] = total / (k + 1)
            if k + 1 < LEAN_TERMS:
                moved = -lean[k, i]
                for n in range(at[i], at[i + 1]):
                    j = there[n]
                    if piece[j] == 0:
                        moved += weight[n] * lean[k, j]
                lean[k + 1, i] = moved / (k + 1)
            most = max(most, abs(series[k + 1, i]))
        power *= s
        if most * power <= LEFT_OUT * size and k > 2:
            return k + 2
    return TERMS


@kept_helper(error_model="numpy")
def gap_of(at, there, weight, drive, limited, piece, series, terms, i, side, gap):  # type: ignore[no-untyped-def]
    """Write how far a cell is from the kink on one side as a polynomial of time; a stopped one: its rate in."""
    if limited and piece[i] != 0:
        for k in range(terms):
            total = (drive[i] if k == 0 else 0.0) - series[k, i]
            for n in range(at[i], at[i + 1]):
                j = there[n]
                total += weight[n] * (series[k, j] if piece[j] == 0 else piece[j] * (k == 0))
            gap[k] = total * piece[i]
        return
    sign = piece[i] if piece[i] != 0 else -side
    for k in range(terms):
        gap[k] = sign * series[k, i]
    gap[0] += -1.0 if piece[i] != 0 else 1.0


@kept_njit(error_model="numpy")
def flow(at, there, weight, drive, free, limited, x, push, piece, duration, longest, most):  # type: ignore[no-untyped-def]
    """Take state and push (cells,) through the time in place.

    Returns the kinks met, the time left (0: all is done) and how often A y was evaluated.

    ``at``, ``there``, ``weight``: A as compressed rows; ``longest`` time of a series; ``most`` kinks.
    """
    cells = x.size
    series, lean = np.empty((TERMS, cells)), np.empty((LEAN_TERMS, cells))
    gap, met = np.empty(TERMS), np.empty((2 * cells, 3))
    usual, left, kinks, evaluations = longest, duration, 0, 0
    while left > 0 and kinks <= most:
        s = min(longest, left, LOOK_AHEAD * usual)
        terms = series_of(at, there, weight, drive, free, limited, piece, x, push, s, series, lean)
        evaluations += terms - 1
        best, found = s, 0
        for i in range(cells):
            if not free[i]:
                continue
            reach, power = 0.0, 1.0
            for k in range(1, terms):
                power *= s
                reach += abs(series[k, i]) * power
            for side in (1.0, -1.0):
                if piece[i] != 0 and (side < 0 or (not limited and piece[i] * x[i] - 1 > reach)):
                    continue
                if piece[i] == 0 and 1 - side * x[i] > reach:
                    continue
                gap_of(at, there, weight, drive, limited, piece, series, terms, i, side, gap)
                t = crossing(gap[:terms], s)
                if t <= best + TOGETHER:
                    best = min(best, t)
                    met[found, 0], met[found, 1], met[found, 2] = t, i, side if piece[i] == 0 else piece[i]
                    found += 1
        for i in range(cells):
            x[i], push[i] = value(series[:terms, i], best), value(lean[: min(terms, LEAN_TERMS), i], best)
        for n in range(found):
            if met[n, 0] <= best + TOGETHER:
                i = int(met[n, 1])
                x[i] = met[n, 2]
                piece[i] = 0.0 if piece[i] != 0 else met[n, 2]
                if limited:
                    push[i] = 0.0
                kinks += 1
        usual = min(longest, 0.8 * usual + 0.2 * best) if found else min(longest, 2 * usual)
        left -= best
        if left < 1e-14 * duration:
            left = 0.0
    return kinks, left, evaluations
