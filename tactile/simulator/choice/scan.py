"""One pass over readings for their extremes, compiled."""

from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.core.frame import NORMAL


@kept_njit()
def scan(values, first, last, peaks, where, ends):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Go on with every channel's peak and frame, and with the least and largest normal reading and largest step."""
    for n in range(values.shape[0]):
        for c in range(values.shape[1]):
            value = values[n, c]
            before = last[c] if n == 0 else values[n - 1, c]
            ends[2] = max(ends[2], abs(value - before))
            if abs(value) > peaks[c]:
                peaks[c], where[c] = abs(value), n + first
            if c % 3 == NORMAL:
                ends[0], ends[1] = min(ends[0], value), max(ends[1], value)
