"""Epoch: the instant from which a stream's times count, read on both clocks of the host at once."""

import time
from dataclasses import dataclass
from typing import Self

TRIES = 5
"""Readings of which the quickest counts: between two calls another program may have its turn."""


@dataclass(frozen=True)
class Epoch:
    """One instant: ``monotonic`` [ns] on the clock that only goes forward, ``unix`` [ns] since 1970."""

    monotonic: int
    unix: int

    @classmethod
    def now(cls) -> Self:
        """Return this instant, both clocks read within a microsecond or two."""
        readings = [(time.monotonic_ns(), time.time_ns(), time.monotonic_ns()) for _ in range(TRIES)]
        before, unix, after = min(readings, key=lambda reading: reading[2] - reading[0])
        return cls((before + after) // 2, unix)
