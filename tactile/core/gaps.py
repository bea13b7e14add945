"""Gaps in the times of frames: stretches without frames that are far longer than the usual interval."""

from collections import deque

import numpy as np

LEAST, MANY = 0.5, 10.0
"""Shortest gap [s], and in units of the usual interval."""
KNOWN, KEPT = 3, 64
"""Least number of intervals from which the usual one is known, and number of recent intervals."""


class Gaps:
    """Called with the time [s] of each frame of a finger; returns the time of the frame before a gap, or None.

    The usual interval is the median of the recent ones above 0: frames of one stamp have none.
    """

    def __init__(self) -> None:
        self._intervals: deque[float] = deque(maxlen=KEPT)
        self._last: float | None = None

    def __call__(self, t: float) -> float | None:
        """Process a frame."""
        last, self._last = self._last, t
        if last is None or t <= last:
            return None
        interval = t - last
        if interval > LEAST and len(self._intervals) >= KNOWN and interval > MANY * float(np.median(self._intervals)):
            return last
        self._intervals.append(interval)
        return None
