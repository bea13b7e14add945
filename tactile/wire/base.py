"""Decoder and encoder of a wire format: bytes to readings with counted faults, without port or clock.

The output of a decoder depends only on the bytes, not on how they are cut into chunks: each decision is made at the
first byte that settles it, and is final.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from cnnsim.support import Floats

NEXT = 1024
"""Largest difference of sequence numbers that counts as lost frames: a second of frames."""
Taxels = Floats
"""(taxels, 3): readings in the device's order and unit, last axis (x, y, z) of the device."""


@dataclass
class Counts:
    """Counters of a stream.

    ``good`` frames; ``bad_checksum`` frames that began but had no valid end; ``resynchronised`` bytes outside frames;
    ``missing`` frames by sequence number; ``missing_by_rate`` an estimate for frames without a number; ``repeated``
    frames, which are dropped; ``unfit`` complete frames of another shape than described; ``late`` frames more than
    `clock.LATE` behind the line of the device clock; ``overflowed`` bytes dropped by a full queue.
    """

    good: int = 0
    bad_checksum: int = 0
    resynchronised: int = 0
    missing: int = 0
    missing_by_rate: int = 0
    repeated: int = 0
    unfit: int = 0
    late: int = 0
    overflowed: int = 0

    def plain(self) -> dict[str, int]:
        """Return the counters by name."""
        return asdict(self)

    def __str__(self) -> str:
        return ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in self.plain().items())


@dataclass(frozen=True)
class Reading:
    """One decoded frame.

    ``values`` (taxels, 3); ``device`` number of the board on this wire, None if one frame has all of them in order;
    ``sequence`` number of the device, None without one; ``t_device`` [s], NaN without a device clock; ``end`` position
    in the stream after this frame; ``checked`` whether a CRC protects the frame, so that its sequence number can be
    trusted.
    """

    values: Taxels
    end: int
    device: int | None = None
    sequence: int | None = None
    t_device: float = float("nan")
    checked: bool = True


@dataclass(frozen=True)
class Found:
    """Next item in the buffer: ``skip`` bytes outside frames, then a frame of ``length`` bytes, if not 0."""

    skip: int
    length: int = 0
    reading: Reading | None = None


class Decoder(ABC):
    """Bytes in, readings out. A format implements `_next`, which finds the next item in ``self._buffer``."""

    def __init__(self) -> None:
        self.counts = Counts()
        self._buffer = bytearray()
        self._begin = 0  # the place of buffer[0] in the stream
        self._last: dict[int | None, int] = {}
        self._leapt: dict[int | None, int] = {}  # a number that leapt in a frame without a checksum

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
            if found.reading is not None and self._is_new(found.reading):
                self.counts.good += 1
                readings.append(found.reading)
        return readings

    def _drop(self, count: int) -> None:
        self.counts.resynchronised += count
        self._begin += count
        del self._buffer[:count]

    def _is_new(self, reading: Reading) -> bool:
        """Count by sequence number; a step back or of over half the range is a restarted device."""
        if reading.sequence is None:
            return True
        if reading.device not in self._last:
            self._last[reading.device] = reading.sequence
            return True
        step = (reading.sequence - self._last[reading.device]) % 2**32
        if step == 0 or reading.sequence == self._leapt.get(reading.device):
            self.counts.repeated += 1
            return False
        if step == 1 or reading.checked:
            self._believe(reading.device, reading.sequence, step)
        else:
            self._weigh(reading.device, reading.sequence, step)
        return True

    def _weigh(self, device: int | None, sequence: int, step: int) -> None:
        """Accept a jump of an unprotected sequence number when the next frame continues from it.

        If the next frame continues from the number before, the jump was a corrupted number.
        """
        doubted = self._leapt.get(device)
        if doubted is None:
            self._leapt[device] = sequence
        elif step < NEXT:
            self._believe(device, sequence, step - 1)
        elif (onward := (sequence - doubted) % 2**32) < NEXT:
            self._believe(device, doubted, (doubted - self._last[device]) % 2**32)
            self._believe(device, sequence, onward)
        else:
            self._leapt[device] = sequence

    def _believe(self, device: int | None, sequence: int, step: int) -> None:
        self._last[device] = sequence
        self._leapt.pop(device, None)
        if step < 2**31:
            self.counts.missing += step - 1


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
    """Parameters of a format: ``shapes`` (rows, cols) of the boards, and ``extra`` options of that format."""

    shapes: tuple[tuple[int, int], ...]
    extra: dict[str, Any] = field(default_factory=dict)

    @property
    def taxels(self) -> tuple[int, ...]:
        """Number of taxels of every board."""
        return tuple(rows * cols for rows, cols in self.shapes)
