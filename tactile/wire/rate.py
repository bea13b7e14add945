"""Frames that are missing by the device's rate, for formats whose frames carry no number.

What comes over a cable can be late, never early. So a frame that was delayed is caught up with by those after it, and
one that was lost is not: from then on all come a period later. The period is the mean of spans of eight frames, those
left out in which one is missing; of every sixteen frames the one least behind its place counts, and what the next
hundred or so do not catch up with is lost.

It is an estimate: one frame lost in a hundred is found nearly always, one in twenty every other time; where arrivals
scatter by half a period, fewer. Of a device that sends when it likes nothing is counted.
"""

from collections import deque

import numpy as np

SPAN = 8
"""Frames from one arrival to the other of which the period is made."""
SPANS = 64
"""The latest of them that count."""
BIN, BINS = 16, 8
"""Frames of which the least late counts, and so many of these that a loss must outlast."""
STEADY = 0.35
"""Of the spans, the share that has to agree within half a period."""
ANEW = 0.2
"""Relative change of the period that makes it another rate."""


class RateGaps:
    """Counts in ``missing`` the frames that should have come between those that did."""

    def __init__(self) -> None:
        self.missing = 0
        self._arrivals: deque[float] = deque(maxlen=SPANS + SPAN)
        self.restart()

    def restart(self) -> None:
        """Forget the rate: what follows is a new stream."""
        self._arrivals.clear()
        self._period = 0.0
        self._count = 0
        self._levels: deque[float] = deque(maxlen=BINS)
        self._base = 0.0
        self._before: tuple[int, float] | None = None

    def see(self, arrival: float) -> None:
        """Take the arrival of the next frame [s]."""
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
            self.missing = max(0, self.missing + lost)  # fewer again where frames caught up later than expected
            self._base = least


def _period(times: np.ndarray) -> float | None:
    """Return the period [s] of frames that arrived at such times, None where they keep none."""
    spans = (times[SPAN:] - times[:-SPAN]) / SPAN
    middle = float(np.median(spans))
    agreeing = spans[np.abs(spans - middle) < middle / 2 / SPAN]
    if middle <= 0 or agreeing.size < STEADY * spans.size:
        return None
    return float(agreeing.mean())
