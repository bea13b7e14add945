"""Frames from chunks of bytes, of a port or of a recording of one."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from tactile.core.frame import Frame
from tactile.core.source import Provenance
from tactile.wire.arrange import Arrange
from tactile.wire.base import Counts, Reading
from tactile.wire.clock import ClockLine
from tactile.wire.description import Description
from tactile.wire.rate import RateGaps

PLUGGED, UNPLUGGED, DAMAGED = "plugged", "unplugged", "damaged"
TARE, FORCED_TARE = "tare", "tare by force"
"""Notes of a chunk without bytes; damaged: bytes of a recording are lost at this point."""


@dataclass(frozen=True)
class Chunk:
    """Bytes that arrived together, ``t`` [ns] after the start of the stream; ``note`` marks another occurrence."""

    t: int
    data: bytes = b""
    note: str = ""


class WireSource:
    """Frames decoded from chunks, as a ``Source``. They depend on the chunks only.

    ``see``: called with every frame; ``tare_requests``: one entry per requested tare that is not taken yet, True to
    force it; ``arrival`` [ns] of the last frame, on the clock of the chunks; ``notes``: warnings about the recording.
    """

    notes: tuple[str, ...] = ()

    def __init__(
        self,
        description: Description,
        chunks: Iterable[Chunk],
        see: Callable[[Frame], None] | None = None,
    ) -> None:
        self.title, self.arrays, self.modulus = description.title, description.arrays, description.modulus
        self.provenance = Provenance(True, description.uncalibrated, None, description.text)
        self.frames: int | None = None
        self.arrival = 0
        self.clock = ClockLine()
        self._rate, self._is_asked = RateGaps(), bool(description.wire.talk(description.options).poll)
        self.decoder = description.wire.decoder(description.options)
        self.tare_requests: deque[bool] = deque()
        self._arrange, self._chunks, self._see = Arrange(description), chunks, see

    @property
    def counts(self) -> Counts:
        """Counters of the stream."""
        counts = self.decoder.counts
        counts.late = self.clock.late
        counts.missing_by_rate = self._rate.missing
        return counts

    def __iter__(self) -> Iterator[Frame]:
        for chunk in self._chunks:
            self.arrival = chunk.t
            if chunk.note in (TARE, FORCED_TARE):
                self.tare_requests.append(chunk.note == FORCED_TARE)
            broken_off = chunk.note in (UNPLUGGED, DAMAGED)
            if broken_off:
                self._rate.restart()
            readings = self.decoder.finish() if broken_off else self.decoder.feed(chunk.data)
            for reading in readings:
                yield from self._frames(reading)
        for reading in self.decoder.finish():
            yield from self._frames(reading)

    def _frames(self, reading: Reading) -> Iterator[Frame]:
        if reading.sequence is None and not self._is_asked:
            self._rate.see(self.arrival * 1e-9)
        t = self.clock(reading.t_device, self.arrival * 1e-9)
        for frame in self._arrange(reading, t):
            if self._see is not None:
                self._see(frame)
            yield frame
