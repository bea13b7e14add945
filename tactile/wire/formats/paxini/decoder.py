"""Paxini PX-6AX GEN3 decoders: high-speed board, which pushes frames, and serial converter board, which is polled.

Packets are those of `paxini.packet`. Pushed data hold for every module a resultant of 6 bytes (three int16) where
option ``resultant`` is true, then its points; answers hold the points of one module, and status 1 comes with valid
ones. Bytes at random pass once in 2^40 (push: two start bytes, 00 and the length's two bytes are fixed) or 2^88 tries,
each still times 2^8 for the LRC. Replies of the high-speed board to commands are ignored.
"""

import struct
from abc import abstractmethod

import numpy as np

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Found, Options, Talk
from tactile.wire.formats.paxini import packet as px
from tactile.wire.formats.paxini.device import AnswerEncoder, PushEncoder
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format


class PaxiniDecoder(Decoder):
    """Base of both decoders: a start, a length, a check byte at the end."""

    starts: tuple[bytes, ...]

    def _next(self, over: bool) -> Found | None:
        data = self._buffer
        found = [at for at in map(data.find, self.starts) if at >= 0]
        at = min(found, default=len(data) - data.endswith(px.REPLY[:1]))
        if at:
            return Found(at)
        length = self._length(bytes(data[:13]))
        if length is None or (over and len(data) < (length or len(data) + 1)):
            return Found(1)  # at the end, a stump with nothing to come that would complete it
        if not length or len(data) < length:
            return None
        packet = bytes(data[:length])
        if px.lrc(packet[:-1]) != packet[-1]:
            self.counts.bad_checksum += 1
            return Found(1)
        if not self._carries(packet):
            return Found(0, length)
        values = self._values(packet)
        if values is None:
            self._count_unfit(f"a packet of {length} bytes")
            return Found(length)
        return Found(0, length, Reading(values, self._begin + length))

    @abstractmethod
    def _length(self, head: bytes) -> int | None:
        """Return the length of the packet that begins so: None if none does, 0 while that is open."""

    def _carries(self, packet: bytes) -> bool:
        """Return whether a packet has readings; what has none is a reply."""
        return True

    @abstractmethod
    def _values(self, packet: bytes) -> Taxels | None:
        """Return the points of all modules, None if the packet is of another shape."""


class PushDecoder(PaxiniDecoder):
    """Decodes frames of the high-speed board."""

    starts = px.PUSH, px.REPLY

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels, self._resultant = options.taxels, px.RESULTANT * px.resultant(options)
        if len(self._taxels) > px.SLOTS:
            raise InputError(f"paxini-fast: {len(self._taxels)} modules; the board has slots for {px.SLOTS}")
        self._bytes = sum(3 * count + self._resultant for count in self._taxels)
        self._longest = px.longest(self._bytes)

    def _length(self, head: bytes) -> int | None:
        reply = head[:2] == px.REPLY
        if len(head) < (8 if reply else 5):
            return 0
        if head[2] != 0:
            return None
        if reply:
            _, function, _, dlen = px.FAST.unpack_from(head, 2)
            return dlen + 9 if function & 0x7F in (px.READ, px.WRITE, px.CALIBRATE) and dlen <= 512 else None
        (length,) = struct.unpack_from("<H", head, 3)
        return length + 6 if 1 <= length <= self._longest else None

    def _carries(self, packet: bytes) -> bool:
        return packet[:2] == px.PUSH and len(packet) > 7  # a write to the push register is answered by an empty push

    def _values(self, packet: bytes) -> Taxels | None:
        data, at, boards = packet[6:-1], 0, []
        if len(data) != self._bytes:
            return None
        for count in self._taxels:
            at += self._resultant
            boards.append(px.points(data, count, at))
            at += 3 * count
        return np.concatenate(boards)


class AnswerDecoder(PaxiniDecoder):
    """Decodes answers of the serial converter board to the request for one module's points."""

    starts = (px.REPLY,)

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels = px.one_module(options)
        self._longest = px.longest(3 * self._taxels)

    def _length(self, head: bytes) -> int | None:
        if len(head) < 13:
            return 0
        length, *fixed, dlen = px.SLOW.unpack(head[2:])
        wanted = (1, 0, px.READ_FORCE, px.POINTS_ADDRESS)
        return length + 5 if tuple(fixed) == wanted and length == dlen + 10 <= self._longest else None

    def _values(self, packet: bytes) -> Taxels | None:
        return px.points(packet, self._taxels, 14) if len(packet) == 15 + 3 * self._taxels else None


def _push_talk(options: Options) -> Talk:
    types = px.fast_request(px.WRITE, px.DATA_TYPE, bytes([2 + px.resultant(options)]))
    return Talk(hello=types + px.fast_request(px.WRITE, px.AUTO_PUSH, b"\1"))


def _answer_talk(options: Options) -> Talk:
    count = 3 * px.one_module(options)
    return Talk(poll=px.slow_request(px.READ_FORCE, px.POINTS_ADDRESS, count=count), period=1 / 176)


FORMATS = {
    "paxini-fast": Format(
        "paxini-fast",
        "Paxini PX-6AX GEN3 on the high-speed board",
        921600,
        5.0,
        PushDecoder,
        PushEncoder,
        _push_talk,
        ("resultant",),
        True,
    ),
    "paxini-serial": Format(
        "paxini-serial",
        "Paxini PX-6AX GEN3 on the serial converter board",
        921600,
        5.0,
        AnswerDecoder,
        AnswerEncoder,
        _answer_talk,
        (),
        True,
        single=True,
    ),
}
