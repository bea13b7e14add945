"""Session on a port: chunks are recorded, then decoded to frames for the consumer."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from tactile.core.epoch import Epoch
from tactile.core.frame import Frame
from tactile.recording.writer import Recording
from tactile.serial.port_check import PortCheck
from tactile.serial.reader import PortReader
from tactile.serial.ring import Ring
from tactile.wire.description import Description
from tactile.wire.reading import Counts
from tactile.wire.source import PLUGGED, Chunk, WireSource

NAP = 0.1
"""[s] Longest wait before a thread checks whether to stop."""
BEHIND = 1.0
"""[s] Age of a chunk that is taken from the queue from which a warning is issued."""


class Session:
    """Reads a port until `stop`, for ``seconds``, or with ``once`` until it is unplugged; records every byte first.

    ``record`` makes the ``recording`` once the port is open, given the epoch of all times. ``stopped``: the event that
    `stop` sets, if it is needed before the port is open. ``warn`` is called when within three seconds nothing comes, or
    nothing that fits the description, and when chunks are taken more than `BEHIND` after their arrival.

    Flow: drain process -> recording -> ring -> iteration over ``source``. Bytes dropped by the ring are still recorded,
    as unparsed.

    Raises:
        InputError: the port cannot be opened, or the recording cannot be made.
    """

    def __init__(
        self, port: str, description: Description, record: Callable[[Epoch], Recording] | None = None,
        seconds: float | None = None, once: bool = False,
        stopped: threading.Event | None = None, warn: Callable[[str], None] = lambda text: None,
    ) -> None:  # fmt: skip
        self._ready, self._warn = Ring(), warn
        self._received = self._decoded = 0  # bytes
        self._is_behind = False
        self._stopped = stopped or threading.Event()
        talk = description.wire.talk(description.options)
        self.reader = PortReader(port, description.baudrate, talk, self._take, self._ready.close, once)
        self.recording: Recording | None = None
        self._lock = threading.Lock()  # of a recording that ends while bytes arrive
        if record is not None:
            try:
                self.recording = record(self.reader.epoch)
            except BaseException:
                self.reader.close()
                raise
        self._until = float("inf") if seconds is None else time.monotonic() + seconds
        self.source = WireSource(description, self._chunks(), self._keep, warn)
        self.check = PortCheck(port, description, lambda: self.source, warn)

    @property
    def counts(self) -> Counts:
        """All counters of the stream."""
        counts = self.source.counts
        counts.overflowed = self._ready.overflowed + self.reader.dropped
        return counts

    def now(self) -> int:
        """Return [ns] since the stream began."""
        return self.reader.now()

    def note(self, topic: str, t: int, data: dict[str, Any]) -> None:
        """Write a JSON object into the recording, if there is one."""
        with self._lock:
            if self.recording is not None:
                self.recording.note(topic, t, data)

    def begin_recording(self, record: Callable[[Epoch], Recording]) -> None:
        """Record from now on; ``record`` makes the recording.

        Raises:
            InputError: as ``record``.
        """
        recording = record(self.reader.epoch)
        recording.chunk(Chunk(self.now(), note=PLUGGED))
        with self._lock:
            self.recording = recording

    def end_recording(self) -> Recording | None:
        """Record no more, and return the recording, which is to be closed."""
        with self._lock:
            recording, self.recording = self.recording, None
        return recording

    def summary(self) -> dict[str, Any]:
        """Return counters, clock and what the decoder found out, as plain data for the end of a recording."""
        clock, settled = self.source.clock.plain(), self.source.settled()
        return {
            "counts": self.counts.plain(), "clock": clock, "settled": settled, "unplugged": self.reader.unplugged,
        }  # fmt: skip

    def stop(self) -> None:
        """End the frames; bytes received so far still come. Safe in a signal handler."""
        self._stopped.set()

    def close(self) -> None:
        """Close the port; all bytes received are recorded and in the ring."""
        self.stop()
        self.reader.close()

    def _chunks(self) -> Iterator[Chunk]:
        closing = False
        self.reader.start()  # not before a consumer iterates, or chunks would wait for it
        while True:
            over = self._ready.closed
            chunks = self._ready.get(0)
            if not chunks and not over:
                chunks = self._ready.get(0 if self.reader.poll(NAP) else NAP)
            for chunk in chunks:
                self.check.see(chunk)
                if chunk.data and not self._is_behind and self.now() - chunk.t > BEHIND * 1e9:
                    self._report_behind((self.now() - chunk.t) * 1e-9)
                yield chunk
                self._decoded += len(chunk.data)
            self.check.look(not self.reader.why and not closing)
            if over and not chunks:
                return
            if not closing and (self._stopped.is_set() or time.monotonic() >= self._until or self._failed()):
                self.check.look(not self.reader.why and not self.source.counts.good, over=True)
                self.close()  # from here the ring is only emptied
                closing = True

    def _report_behind(self, age: float) -> None:
        self._is_behind = True
        counts, waiting = self.counts, self._received - self._decoded
        frames = round(waiting * counts.good / self._decoded) if self._decoded else 0
        dropped = f", {counts.overflowed} bytes are dropped" if counts.overflowed else ""
        self._warn(
            f"frames are processed {age:.1f} s after their arrival: {frames} frames ({waiting} bytes) wait{dropped};"
            " fewer programs, taxels or frames a second wanted"
        )

    def _failed(self) -> bool:
        return self.recording is not None and bool(self.recording.failed)

    def _take(self, chunks: list[Chunk]) -> None:
        """Record chunks, then queue them for decoding."""
        with self._lock:
            for chunk in chunks:
                room = self._ready.put(chunk)
                self._received += len(chunk.data) * room
                if self.recording is not None:
                    self.recording.chunk(chunk, room)
            if self.recording is not None:
                self.recording.push()

    def _keep(self, frame: Frame) -> None:
        if self.recording is None:
            return
        with self._lock:
            if self.recording is not None:
                self.recording.frame(frame, self.source.arrival)
