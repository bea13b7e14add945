"""Frames from chunks of bytes: the same code for a port and for a recording of one."""

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
"""What a chunk without bytes can say; damaged: of a recording, what came here is lost."""


@dataclass(frozen=True)
class Chunk:
    """Bytes that arrived together, ``t`` [ns] after the stream began; ``note`` says something else happened."""

    t: int
    data: bytes = b""
    note: str = ""


class WireSource:
    """Frames out of chunks, as a ``Source``. Everything about them follows from the chunks alone.

    ``see``: called with every frame; ``tare_requests``: whether by force, one for each tare that was asked for and that
    nobody has taken yet; ``arrival`` [ns] of the frame that was given out last, on the clock of the chunks; ``notes``:
    what is wrong with the recording that they come from, in words.
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
        """What has been seen so far."""
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
