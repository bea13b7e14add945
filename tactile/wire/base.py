"""Decoder and encoder of a wire format: bytes in, readings and counted faults out; no port and no clock here.

A decoder's answer depends on the bytes alone, not on how they were cut: every decision is taken at the first byte that
settles it, and no later byte takes it back.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from cnnsim.support import Floats

NEXT = 1024
"""A sequence number less than this after another goes on from it, whatever was lost between: a second of frames."""
Taxels = Floats
"""(taxels, 3): readings in the device's order and unit, last axis (x, y, z) as the device names them."""


@dataclass
class Counts:
    """What has been seen of a stream.

    ``good`` frames; ``bad_checksum`` frames that began but never checked out; ``resynchronised`` bytes that belong to
    no frame; ``missing`` frames by the sequence number; ``missing_by_rate`` an estimate for frames without one;
    ``repeated`` frames, which are not given out; ``unfit`` frames that are whole but not of the described shape;
    ``late`` frames that arrived more than `clock.LATE` after the device clock's line; ``overflowed`` bytes for which
    there was no room.
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
    """One frame as it came over the wire.

    ``values`` (taxels, 3); ``device`` which of the boards on this wire, None where one frame holds all of them one
    after the other; ``sequence`` the device's count, None where it has none; ``t_device`` [s], NaN where it has no
    clock; ``end`` the number of bytes of the stream up to the end of this frame; ``checked`` whether a CRC covers the
    frame and so its sequence number; of a plain sum changes may cancel.
    """

    values: Taxels
    end: int
    device: int | None = None
    sequence: int | None = None
    t_device: float = float("nan")
    checked: bool = True


@dataclass(frozen=True)
class Found:
    """The next thing in the buffer: ``skip`` bytes that are no frame, then a frame of ``length`` bytes if not 0."""

    skip: int
    length: int = 0
    reading: Reading | None = None


class Decoder(ABC):
    """Bytes in, readings out. A format says in `_next` what comes next in ``self._buffer``."""

    def __init__(self) -> None:
        self.counts = Counts()
        self._buffer = bytearray()
        self._begin = 0  # the place of buffer[0] in the stream
        self._last: dict[int | None, int] = {}
        self._leapt: dict[int | None, int] = {}  # a number that leapt in a frame without a checksum

    def feed(self, data: bytes) -> list[Reading]:
        """Take the next bytes of the stream, however cut, and return the readings that they complete."""
        self._buffer += data
        return self._drain(False)

    def finish(self) -> list[Reading]:
        """Return what can still be read when no byte follows: at the end, or when the plug is pulled."""
        readings = self._drain(True)
        self._drop(len(self._buffer))
        self._restart()
        return readings

    def settled(self) -> dict[str, Any]:
        """Return what the decoder has found out about the device by itself, as plain data."""
        return {}

    @abstractmethod
    def _next(self, over: bool) -> Found | None:
        """Return what the buffer begins with, None while that is open; ``over``: no byte follows."""

    def _restart(self) -> None:  # noqa: B027 - most formats remember nothing between frames
        """Forget where frames lie: what follows is a new stream."""

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
        """Count what the sequence number says; a step back or over half the range is a device that began anew."""
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
        """Believe a leap of a number that no checksum covers when the next frame goes on from there.

        Where the next frame goes on from the number before, the one between was that frame, its number changed.
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
    """A device's side of the wire: readings in, bytes out, commands obeyed. What tests and `tactile emulate` send.

    It begins as the last host left it: sending. A device that only answers is ``polled``; ``asked`` counts the requests
    for readings that it has received.
    """

    polled = False
    asked = 0

    def preamble(self) -> bytes:
        """Return what the device sends when it starts."""
        return b""

    @abstractmethod
    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one instant's bytes of all boards; readings out of the format's range are clipped.

        A device that was told to be silent, or to send less often, returns nothing.

        Arguments: ``boards`` (taxels, 3) of every board, in the device's unit; ``t_device`` [s].
        """

    def receive(self, data: bytes) -> bytes:
        """Take what the host says, however cut, obey it, and return the answer. Most devices ignore it."""
        return b""


@dataclass(frozen=True)
class Talk:
    """What a host has to say to a device: ``hello`` once, ``poll`` every ``period`` [s] where it only answers."""

    hello: bytes = b""
    poll: bytes = b""
    period: float = 0.0


@dataclass(frozen=True)
class Options:
    """What a format must be told: ``shapes`` (rows, cols) of the boards, and ``extra`` options of that format."""

    shapes: tuple[tuple[int, int], ...]
    extra: dict[str, Any] = field(default_factory=dict)

    @property
    def taxels(self) -> tuple[int, ...]:
        """Number of taxels of every board."""
        return tuple(rows * cols for rows, cols in self.shapes)
