"""Onset of a change of shear, compiled: a fit of straight lines with a bend to the last 0.3 s."""

import math

from cnnsim.support.compiled_loops import kept_helper, kept_njit

KEPT, EACH = 128, 0.004
"""Number of stored frames, and the least time between two [s]: half a second at 1000 Hz, more at lower rates."""
LOOK = 0.3
"""[s] Length of the fitted interval."""
LEAST = 8
"""Least number of frames of a fit."""
BETTER = 0.5
"""Residual of two bends over that of one, below which two are used: a load may begin softly."""


@kept_njit(error_model="numpy")
def remember(t, fast, times, past, state):  # type: ignore[no-untyped-def]  # typed at the call
    """Store the means ``fast`` (rows, cols, 3) in the ring ``past`` (KEPT, rows, cols, 3), and ``t`` [s] in ``times``.

    ``state`` (2,): next index and number of stored frames.
    """
    last = (state[0] - 1) % KEPT
    if state[1] > 0 and t < times[last]:  # the clock went back
        state[0] = state[1] = 0
    elif state[1] > 0 and t - times[last] < EACH:
        return
    times[state[0]] = t
    _, rows, cols, parts = past.shape
    for i in range(rows):  # an assignment of arrays takes seconds to compile
        for j in range(cols):
            for m in range(parts):
                past[state[0], i, j, m] = fast[i, j, m]
    state[0] = (state[0] + 1) % KEPT
    state[1] = min(state[1] + 1, KEPT)


@kept_njit(error_model="numpy")
def bend(t, drawn, slow, explained, times, past, state, series, hinges):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the time [s] at which the shear of the drawn taxels began to change, ``t`` if unknown.

    The shear s along ``drawn`` (2, rows, cols), minus the part that the pressing explains, is fitted by a + b t + c
    max(t - t0, 0) over the last `LOOK`; t0 has the least squares. Where a fit with two such bends halves the residual,
    the steeper of the two is the onset: a slow creep before it is not the load. ``explained``: whether pressing
    explains shear; ``slow`` (rows, cols, 3) gives its ratio; ``series`` (2, KEPT) and ``hinges`` (KEPT, KEPT) are
    scratch.
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
    """Return the time of the steepest upward bend of a series (count,), of one or two bends; 0 without one."""
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
    """Subtract the least-squares line over ``t`` from ``values`` (count,); return the residual sum of squares."""
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
