"""Where a change of shear set in, compiled: the bend of the last 0.3 s, found when a tangential load is told."""

import math

from cnnsim.support.compiled_loops import kept_helper, kept_njit

KEPT, EACH = 128, 0.004
"""Frames that are remembered, and the least time between two [s]: the last half second at 1000 Hz, more at less."""
LOOK = 0.3
"""[s] that is looked back over."""
LEAST = 8
"""Frames that a bend needs; with fewer nothing is said of it."""
BETTER = 0.5
"""Two bends are told where they leave less than this part of the squares that one leaves: a load may come softly."""


@kept_njit(error_model="numpy")
def remember(t, fast, times, past, state):  # type: ignore[no-untyped-def]  # typed at the call
    """Keep the means ``fast`` (rows, cols, 3) in ``past`` (KEPT, rows, cols, 3) at the time ``t`` [s] in ``times``.

    ``state`` (2,): where the next goes, and how many there are.
    """
    last = (state[0] - 1) % KEPT
    if state[1] > 0 and t < times[last]:  # a clock that went back
        state[0] = state[1] = 0
    elif state[1] > 0 and t - times[last] < EACH:
        return
    times[state[0]] = t
    _, rows, cols, parts = past.shape
    for i in range(rows):  # by hand: an assignment of arrays takes seconds to compile
        for j in range(cols):
            for m in range(parts):
                past[state[0], i, j, m] = fast[i, j, m]
    state[0] = (state[0] + 1) % KEPT
    state[1] = min(state[1] + 1, KEPT)


@kept_njit(error_model="numpy")
def bend(t, drawn, slow, explained, times, past, state, series, hinges):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the time [s] at which the shear of the taxels drawn began to change, ``t`` where that cannot be said.

    The shear s along what is ``drawn`` (2, rows, cols), less what the pressing explains, is fitted by
    a + b t + c max(t - t0, 0) over the last `LOOK`: t0 is the time that leaves least squares. Where two such bends
    leave far less it is the one that turns upwards more: what crept a little before is not yet the load.
    ``explained``: whether the pressing explains shear; ``slow`` (rows, cols, 3) says how much for each newton;
    ``series`` (2, KEPT) and ``hinges`` (KEPT, KEPT) are scratch.
    """
    count = 0
    _, rows, cols = drawn.shape
    for m in range(state[1]):
        at = (state[0] - 1 - m) % KEPT
        if t - times[at] > LOOK:
            break
        s = 0.0
        for i in range(rows):
            for j in range(cols):
                for k in range(2):
                    if abs(drawn[k, i, j]) >= 0.25:
                        part = slow[i, j, k] / slow[i, j, 2] if explained and slow[i, j, 2] > 0 else 0.0
                        along = past[at, i, j, k] - part * past[at, i, j, 2]
                        s += along if drawn[k, i, j] > 0 else -along
        series[0, m], series[1, m] = times[at] - t, s
        count += 1
    if count < LEAST:
        return t
    return t + _steepest_bend(series, hinges, count)


@kept_helper(error_model="numpy")
def _steepest_bend(series, hinges, count):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the time of the bend of a course (count,) that turns upwards most, of one or two; 0 where none does."""
    whole = _level(series[1], series[0], count)
    for n in range(2, count - 2):
        for m in range(count):
            hinges[n, m] = max(series[0, m] - series[0, n], 0.0)
        _level(hinges[n], series[0], count)
    one, two, found, steeper = whole, math.inf, 0.0, 0.0
    for n in range(2, count - 2):
        hh, hs = _product(hinges[n], hinges[n], count), _product(hinges[n], series[1], count)
        if hs > 0 and hh > 0 and whole - hs * hs / hh < one:
            one, found = whole - hs * hs / hh, series[0, n]
        for k in range(n + 2, count - 2):
            gg, hg = _product(hinges[k], hinges[k], count), _product(hinges[n], hinges[k], count)
            det = hh * gg - hg * hg
            if det > 1e-9 * hh * gg:
                gs = _product(hinges[k], series[1], count)
                b, c = (hs * gg - gs * hg) / det, (gs * hh - hs * hg) / det
                left = whole - b * hs - c * gs
                if left < two and max(b, c) > 0:
                    two, steeper = left, series[0, n] if b > c else series[0, k]
    return steeper if two < BETTER * one else found


@kept_helper(error_model="numpy")
def _level(values, t, count):  # type: ignore[no-untyped-def]  # typed at the call
    """Take a straight course over ``t`` off ``values`` (count,), least squares; return the squares that are left."""
    mt = mv = 0.0
    for m in range(count):
        mt += t[m] / count
        mv += values[m] / count
    tt = tv = 0.0
    for m in range(count):
        tt += (t[m] - mt) ** 2
        tv += (t[m] - mt) * (values[m] - mv)
    slope = tv / tt if tt > 0 else 0.0
    for m in range(count):
        values[m] -= mv + slope * (t[m] - mt)
    return _product(values, values, count)


@kept_helper(error_model="numpy")
def _product(one, other, count):  # type: ignore[no-untyped-def]  # typed at the call
    total = 0.0
    for m in range(count):
        total += one[m] * other[m]
    return total
