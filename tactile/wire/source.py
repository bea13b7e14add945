"""Frames from chunks of bytes: the same code for a port and for a recording of one."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import LiveTare, TareNote
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import Provenance
from tactile.wire.arrange import Arrange
from tactile.wire.base import Counts, Reading
from tactile.wire.clock import ClockLine
from tactile.wire.description import Description
from tactile.wire.rate import RateGaps

PLUGGED, UNPLUGGED, TARE, DAMAGED = "plugged", "unplugged", "tare", "damaged"
"""What a chunk without bytes can say; damaged: of a recording, what came here is lost."""


@dataclass(frozen=True)
class Chunk:
    """Bytes that arrived together, ``t`` [ns] after the stream began; ``note`` says something else happened."""

    t: int
    data: bytes = b""
    note: str = ""


class WireSource:
    """Frames out of chunks, as a ``Source``. Everything about them follows from the chunks alone.

    ``tares``: how each finger's offset is taken, nothing for none; ``see``: called with every frame before its tare;
    ``arrival`` [ns] of the frame that was given out last, on the clock of the chunks.
    """

    def __init__(
        self,
        description: Description,
        chunks: Iterable[Chunk],
        tares: tuple[LiveTare, ...] = (),
        see: Callable[[Frame], None] | None = None,
    ) -> None:
        self.title, self.arrays, self.modulus = description.title, description.arrays, description.modulus
        self.provenance = Provenance(True, description.uncalibrated, None, description.text)
        self.frames: int | None = None
        self.arrival = 0
        self.clock = ClockLine()
        self._rate, self._is_asked = RateGaps(), bool(description.wire.talk(description.options).poll)
        self.decoder = description.wire.decoder(description.options)
        self._arrange, self._chunks, self._tares, self._see = Arrange(description), chunks, tares, see

    @property
    def counts(self) -> Counts:
        """What has been seen so far."""
        counts = self.decoder.counts
        counts.late = self.clock.late
        counts.missing_by_rate = self._rate.missing
        return counts

    def notes(self) -> list[TareNote]:
        """Return what became of tares since this was last called."""
        taken = [note for tare in self._tares for note in tare.notes]
        for tare in self._tares:
            tare.notes.clear()
        return taken

    def __iter__(self) -> Iterator[Frame]:
        for chunk in self._chunks:
            self.arrival = chunk.t
            if chunk.note == TARE:
                for tare in self._tares:
                    tare.ask()
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
            yield self._tares[frame.finger](frame) if self._tares else frame


def tares_for(
    arrays: tuple[TaxelArray, ...], automatic: bool = True, gains: Gains | None = None
) -> tuple[LiveTare, ...]:
    """Return one tare for each finger; ``gains`` take its readings to the array's quantity."""
    return tuple(LiveTare(finger, array, automatic, gains=gains) for finger, array in enumerate(arrays))
