"""One pass over readings for their extremes, compiled."""

from cnnsim.support.compiled_loops import kept_njit
from tactile.core.frame import NORMAL


@kept_njit()
def scan(values, first, last, peaks, where, ends):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Go on with every channel's peak and frame, and with the least and largest normal reading and largest step."""
    low, high, change = ends[0], ends[1], ends[2]
    for n in range(values.shape[0]):
        for taxel in range(0, values.shape[1], 3):
            for c in range(taxel, taxel + 3):
                value = values[n, c]
                before = last[c] if n == 0 else values[n - 1, c]
                change = max(change, abs(value - before))
                if abs(value) > peaks[c]:
                    peaks[c], where[c] = abs(value), n + first
            low, high = min(low, values[n, taxel + NORMAL]), max(high, values[n, taxel + NORMAL])
    ends[0], ends[1], ends[2] = low, high, change
