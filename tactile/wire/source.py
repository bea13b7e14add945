"""Frames from chunks of bytes, of a port or of a recording of one."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

from cnnsim.support.notices import Notices
from tactile.core.frame import Frame
from tactile.core.source import Provenance
from tactile.wire.arrange import Arrange
from tactile.wire.clock import ClockLine
from tactile.wire.description import Description
from tactile.wire.rate import RateGaps
from tactile.wire.reading import Counts

PLUGGED, UNPLUGGED, DAMAGED, ENDED = "plugged", "unplugged", "damaged", "ended"
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

    ``see``: called with every frame; ``warn``: called with warnings about the device's clock and sequence numbers;
     ``tare_requests``: one entry per requested tare that is not taken yet, True to
    force it; ``arrival`` [ns] of the last frame, on the clock of the chunks. If ``chunks`` can be iterated again, the
    frames can; counters and clock are those of the iteration that began last.
    """

    def __init__(
        self,
        description: Description,
        chunks: Iterable[Chunk],
        see: Callable[[Frame], None] | None = None,
        warn: Callable[[str], None] = Notices.say,
    ) -> None:
        self.title, self.arrays, self.modulus = description.title, description.arrays, description.modulus
        self.provenance = Provenance(True, description.uncalibrated, None, description.text)
        self.frames: int | None = None
        self.tare_requests: deque[bool] = deque()
        self._is_asked = bool(description.wire.talk(description.options).poll)
        self._description, self._chunks, self._see, self._warn = description, chunks, see, warn
        self._begin()

    def _begin(self) -> None:
        self.arrival = 0
        self.clock, self._rate, self._arrange = ClockLine(), RateGaps(), Arrange(self._description)
        self.decoder = self._description.wire.decoder(self._description.options)
        self.tare_requests.clear()
        self._begun = False

    @property
    def counts(self) -> Counts:
        """Counters of the stream."""
        counts = self.decoder.counts
        counts.late = self.clock.late
        counts.missing_by_rate = self._rate.missing
        return counts

    def settled(self) -> dict[str, Any]:
        """Return what the decoder has settled about the stream."""
        return self.decoder.settled()

    def __iter__(self) -> Iterator[Frame]:
        if self._begun:
            self._begin()
        self._begun = True
        decoder, clock, rate, arrange = self.decoder, self.clock, self._rate, self._arrange
        reported: set[str] = set()
        t = 0.0
        for chunk in chain(self._chunks, [Chunk(0, note=ENDED)]):
            if chunk.note != ENDED:
                self.arrival, t = chunk.t, chunk.t * 1e-9
            if chunk.note in (TARE, FORCED_TARE):
                self.tare_requests.append(chunk.note == FORCED_TARE)
            if chunk.note in (UNPLUGGED, DAMAGED):
                rate.restart()
            over = chunk.note in (UNPLUGGED, DAMAGED, ENDED)
            for reading in decoder.finish() if over else decoder.feed(chunk.data):
                if reading.sequence is None and not self._is_asked:
                    rate.see(t)
                for frame in arrange(reading, clock(reading.t_device, t)):
                    if self._see is not None:
                        self._see(frame)
                    yield frame
            for kind, text in (("clock", clock.trouble), ("sequence", decoder.trouble)):
                if text and kind not in reported:
                    reported.add(kind)
                    self._warn(text)
