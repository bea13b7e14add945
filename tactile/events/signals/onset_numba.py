"""Where a change of shear set in, compiled: the bend of the last 0.3 s, found when a tangential load is told."""

import math

from cnnsim.support.compiling.kept_loops import kept_njit

KEPT, EACH = 128, 0.004
"""Frames that are remembered, and the least time between two [s]: the last half second at 1000 Hz, more at less."""
LOOK = 0.3
"""[s] that is looked back over."""
LEAST = 8
"""Frames that a bend needs; with fewer nothing is said of it."""


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
    past[state[0]] = fast
    state[0] = (state[0] + 1) % KEPT
    state[1] = min(state[1] + 1, KEPT)


@kept_njit(error_model="numpy")
def bend(t, drawn, slow, explained, times, past, state, series):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the time [s] at which the shear of the taxels drawn began to change, ``t`` where that cannot be said.

    The shear s along what is ``drawn`` (2, rows, cols), less what the pressing explains, is fitted by
    a + b t + c max(t - t0, 0) over the last `LOOK`: t0 is the time that leaves least squares.
    ``explained``: whether the pressing explains shear; ``slow`` (rows, cols, 3) says how much for each newton;
    ``series`` (2, KEPT) is scratch.
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
    best, found = math.inf, 0.0
    for start in range(2, count - 2):
        left, rise = _left(series, count, series[0, start])
        if left < best and rise > 0:
            best, found = left, series[0, start]
    return t + found


@kept_njit(error_model="numpy")
def _left(series, count, start):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the squares that a + b t + c max(t - start, 0) leaves, and c."""
    mt = mh = ms = 0.0
    for m in range(count):
        mt += series[0, m]
        mh += max(series[0, m] - start, 0.0)
        ms += series[1, m]
    mt, mh, ms = mt / count, mh / count, ms / count
    tt = th = hh = ts = hs = ss = 0.0
    for m in range(count):
        x, h, s = series[0, m] - mt, max(series[0, m] - start, 0.0) - mh, series[1, m] - ms
        tt += x * x
        th += x * h
        hh += h * h
        ts += x * s
        hs += h * s
        ss += s * s
    det = tt * hh - th * th
    if not det > 1e-12 * tt * hh:
        return math.inf, 0.0
    b, c = (ts * hh - hs * th) / det, (hs * tt - ts * th) / det
    return ss - b * ts - c * hs, c
