"""Missing frames estimated from the rate of a device, for formats without sequence numbers.

Frames arrive late, never early. Later frames make up for a delayed frame, but not for a lost one: from then on all
arrive one period later. The period is the mean of spans of eight frames without a gap. Of every sixteen frames the
least delayed one counts, and a delay that the next hundred frames or so do not make up for is a loss.

It is an estimate: it finds nearly every loss at a rate of one frame in a hundred, every other at one in twenty, and
fewer where arrivals scatter by half a period. A device without a fixed rate has no count.
"""

from collections import deque

import numpy as np

SPAN = 8
"""Number of frames of a span, from which the period is computed."""
SPANS = 64
"""Number of recent spans."""
BIN, BINS = 16, 8
"""Frames per bin, of which the least delayed counts, and number of bins that a loss must last."""
STEADY = 0.35
"""Share of the spans that must agree within half a period."""
ANEW = 0.2
"""Relative change of the period that counts as another rate."""


class RateGaps:
    """Counts the missing frames in ``missing``."""

    def __init__(self) -> None:
        self.missing = 0
        self._arrivals: deque[float] = deque(maxlen=SPANS + SPAN)
        self.restart()

    def restart(self) -> None:
        """Forget the rate, because a new stream follows."""
        self._arrivals.clear()
        self._period = 0.0
        self._count = 0
        self._levels: deque[float] = deque(maxlen=BINS)
        self._base = 0.0
        self._before: tuple[int, float] | None = None

    def see(self, arrival: float) -> None:
        """Process the arrival of the next frame [s]."""
        self._arrivals.append(arrival)
        self._count += 1
        if self._count % BIN == 0 and len(self._arrivals) == SPANS + SPAN:
            self._close_bin()

    def _close_bin(self) -> None:
        times = np.array(self._arrivals)
        period = _period(times)
        if period is None:
            self.restart()
            return
        if self._period and abs(period / self._period - 1) > ANEW:
            self._levels.clear()
            self._before = None
        self._period = period
        behind = times[-BIN:] - period * np.arange(BIN)
        first = int(behind.argmin())
        place, t = self._count - BIN + first, float(times[-BIN + first])
        if self._before is None:
            level = self._base = 0.0
        else:
            level = self._levels[-1] + (t - self._before[1]) - period * (place - self._before[0])
        self._before = place, t
        self._levels.append(level)
        if len(self._levels) == BINS:
            least = min(self._levels)
            lost = round((least - self._base) / period)
            self.missing = max(0, self.missing + lost)  # the count falls where frames caught up later than expected
            self._base = least


def _period(times: np.ndarray) -> float | None:
    """Return the period [s] of frames with these arrivals, None without a fixed rate."""
    spans = (times[SPAN:] - times[:-SPAN]) / SPAN
    middle = float(np.median(spans))
    agreeing = spans[np.abs(spans - middle) < middle / 2 / SPAN]
    if middle <= 0 or agreeing.size < STEADY * spans.size:
        return None
    return float(agreeing.mean())
