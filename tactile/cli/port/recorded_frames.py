"""Frames of a recording without wire bytes as a source of a replay: at their own times, with counters."""

import time
from collections import deque
from collections.abc import Iterator

from tactile.core.frame import Frame
from tactile.core.source import Source, provenance
from tactile.wire.clock import ClockLine
from tactile.wire.reading import Counts


class RecordedFrames:
    """The frames of a source, in real time times ``speed``, or as fast as possible.

    ``arrival`` [ns] is the time of the last frame; ``counts`` has the frames; there is no device clock.
    """

    def __init__(self, source: Source, speed: float | None = None) -> None:
        self.title, self.arrays, self.modulus = source.title, source.arrays, source.modulus
        self.frames, self.provenance = source.frames, provenance(source)
        self.tare_requests: deque[bool] = getattr(source, "tare_requests", deque())
        self.arrival, self.clock, self.counts = 0, ClockLine(), Counts()
        self._source, self._speed = source, speed

    def settled(self) -> dict[str, int]:
        """Return what a decoder of a wire has settled: nothing."""
        return {}

    def __iter__(self) -> Iterator[Frame]:
        start: float | None = None
        for frame in self._source:
            if self._speed is not None:
                start = time.monotonic() - frame.t / self._speed if start is None else start
                time.sleep(max(0.0, start + frame.t / self._speed - time.monotonic()))
            self.arrival = round(frame.t * 1e9)
            self.counts.good += 1
            yield frame
