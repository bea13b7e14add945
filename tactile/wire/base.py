"""Decoder and encoder of a wire format: bytes to readings with counted faults, without port or clock.

The output of a decoder depends only on the bytes, not on how they are cut into chunks: each decision is made at the
first byte that settles it, and is final.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tactile.wire.reading import Counts, Reading, Taxels
from tactile.wire.sequence import SequenceCheck

if TYPE_CHECKING:
    from tactile.layout.layout import Layout


@dataclass(frozen=True)
class Found:
    """Next item in the buffer: ``skip`` bytes outside frames, then a frame of ``length`` bytes, if not 0."""

    skip: int
    length: int = 0
    reading: Reading | None = None


class Decoder(ABC):
    """Bytes in, readings out. A format implements `_next`, which finds the next item in ``self._buffer``.

    ``trouble``: a warning about the device, if any; ``unfit``: shape of the last complete frame of another shape.
    """

    def __init__(self) -> None:
        self.counts = Counts()
        self._buffer = bytearray()
        self._begin = 0  # the place of buffer[0] in the stream
        self.trouble = self.unfit = ""
        self._checks: dict[int | None, SequenceCheck] = {}

    def feed(self, data: bytes) -> list[Reading]:
        """Append bytes of the stream, cut anywhere, and return the readings that they complete."""
        self._buffer += data
        return self._drain(False)

    def finish(self) -> list[Reading]:
        """Return what can be decoded when no byte follows: at the end, or when the device is unplugged."""
        readings = self._drain(True)
        self._drop(len(self._buffer))
        self._restart()
        return readings

    def settled(self) -> dict[str, Any]:
        """Return the facts about the device that the decoder found in the data."""
        return {}

    @abstractmethod
    def _next(self, over: bool) -> Found | None:
        """Return the item at the start of the buffer, None while undecided; ``over``: no byte follows."""

    def _restart(self) -> None:  # noqa: B027 - most formats remember nothing between frames
        """Forget the frame positions, because a new stream follows."""

    def _drain(self, over: bool) -> list[Reading]:
        readings = []
        while self._buffer and (found := self._next(over)) is not None:
            self._drop(found.skip)
            if found.length:
                del self._buffer[: found.length]
                self._begin += found.length
            if found.reading is not None and (reading := self._new(found.reading)) is not None:
                self.counts.good += 1
                readings.append(reading)
        return readings

    def _drop(self, count: int) -> None:
        self.counts.resynchronised += count
        self._begin += count
        del self._buffer[:count]

    def _new(self, reading: Reading) -> Reading | None:
        """Return the reading if its sequence number is new or stands still."""
        if reading.sequence is None:
            return reading
        check = self._checks.get(reading.device) or self._checks.setdefault(reading.device, SequenceCheck(self.counts))
        found = check(reading)
        if check.still:
            self.trouble = (
                f"the sequence number stands still at {reading.sequence}: frames are kept without it, and the missing"
                " ones are estimated from the rate"
            )
        return found

    def _count_unfit(self, found: str) -> None:
        """Count a complete frame of another shape, and keep what was ``found``."""
        self.counts.unfit += 1
        self.unfit = found


class Encoder(ABC):
    """Device side of a wire format: readings in, bytes out, requests handled. Used by tests and `tactile emulate`.

    It starts in sending mode. A device that only answers is ``polled``; ``asked`` counts the requests received.
    """

    polled = False
    asked = 0

    def preamble(self) -> bytes:
        """Return the bytes that the device sends at start."""
        return b""

    @abstractmethod
    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return the bytes of all boards at one time; readings out of range are clipped.

        A device that is silenced or sends at a lower rate returns nothing.

        Arguments: ``boards`` (taxels, 3) of every board, in the device's unit; ``t_device`` [s].
        """

    def receive(self, data: bytes) -> bytes:
        """Process bytes of the host, cut anywhere, and return the answer. Most devices ignore them."""
        return b""


@dataclass(frozen=True)
class Talk:
    """Bytes that a host sends to a device: ``hello`` once, ``poll`` every ``period`` [s] if the device only answers."""

    hello: bytes = b""
    poll: bytes = b""
    period: float = 0.0


@dataclass(frozen=True)
class Options:
    """Parameters of a format: ``shapes`` (rows, cols) of the boards, and ``extra`` options of that format.

    ``axes``: numbers of a taxel, 3 or 1 (the normal alone); ``layout``: of text lines with a header line.
    """

    shapes: tuple[tuple[int, int], ...]
    extra: dict[str, Any] = field(default_factory=dict)
    axes: int = 3
    layout: "Layout | None" = None

    @property
    def taxels(self) -> tuple[int, ...]:
        """Number of taxels of every board."""
        return tuple(rows * cols for rows, cols in self.shapes)
