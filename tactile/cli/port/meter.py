"""Latency percentiles and frame rate, in bounded memory."""

import math
from collections import deque
from typing import Any

BINS_PER_DECADE = 50
SHORTEST, DECADES = 1e-6, 8
"""[s] Shortest latency, and number of decades above it, in bins of 5 %."""


class Meter:
    """Collects the latency of every frame [s], and the rate over the last second."""

    def __init__(self) -> None:
        self.frames = 0
        self.longest = 0.0
        self._bins = [0] * (BINS_PER_DECADE * DECADES + 1)
        self._second: deque[float] = deque(maxlen=100_000)

    def add(self, latency: float, now: float) -> None:
        """Count a frame that was done at ``now`` [s], ``latency`` after the arrival of its last byte."""
        self.frames += 1
        self.longest = max(self.longest, latency)
        place = math.log10(max(latency, SHORTEST) / SHORTEST) * BINS_PER_DECADE
        self._bins[min(round(place), len(self._bins) - 1)] += 1
        self._second.append(now)
        while self._second[0] < now - 1.0:
            self._second.popleft()

    def rate(self, now: float) -> float:
        """Return frames per second over the last second."""
        return float(sum(1 for t in tuple(self._second) if t >= now - 1.0))

    def percentile(self, percent: float) -> float:
        """Return the latency [s] of a percentile, to 5 %, at most the longest; NaN before the first frame."""
        wanted, seen = self.frames * percent / 100, 0
        for place, count in enumerate(self._bins):
            seen += count
            if count and seen >= wanted:
                return min(self.longest, float(SHORTEST * 10 ** (place / BINS_PER_DECADE)))
        return math.nan

    def plain(self, now: float) -> dict[str, Any]:
        """Return the figures as plain data."""
        return {
            "frames": self.frames,
            "rate_hz": self.rate(now),
            "latency_median_s": self.percentile(50),
            "latency_p99_s": self.percentile(99),
            "latency_max_s": self.longest,
        }
