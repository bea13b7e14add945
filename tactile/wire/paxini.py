"""Paxini PX-6AX GEN3: the high-speed board, which pushes frames, and the serial converter board, which is asked.

Little endian; LRC is the two's complement of the sum of all bytes before it; a point is int8 Fx, int8 Fy, uint8 Fz in
0.1 N, Fz positive when pressed.

    push    AA 56 | 00 | u16 FL | u8 error | FL - 1 bytes of data | LRC                                FL + 6 bytes
    answer  AA 55 | u16 len | dev 01 | 00 | fc FB | u32 address | u16 dlen | u8 status | data | LRC    len + 5 bytes

Pushed data hold for every module a resultant of 6 bytes (three int16) where option ``resultant`` is true, then its
points; for more than one module this order is not confirmed by a vendor's text. Answers hold the points of one module
(address 0x40E); status 1 comes with valid ones. Bytes at random pass once in 2^40 (push: two start bytes, 00 and the
length's two bytes are fixed) or 2^88 tries, each still times 2^8 for the LRC.

Source: paxini-sdk 0.1.0 ``protocol.py``, ``registers.py``, ``boards``.
"""

import struct
from collections.abc import Sequence

import numpy as np

from cnnsim.errors import InputError
from tactile.wire.base import Decoder, Encoder, Found, Options, Reading, Talk, Taxels
from tactile.wire.registry import Format

NEWTON = 0.1
POINT = np.dtype([("xy", "i1", 2), ("z", "u1")])
RESULTANT = 6
PUSH, ANSWER = bytes.fromhex("aa56"), bytes.fromhex("aa55")
ANSWER_FIXED = struct.Struct("<BBBIH")
READ_POINTS = (0x01, 0x00, 0xFB, 0x40E)
LONGEST = 2048


def lrc(data: bytes | bytearray) -> int:
    """Return the check byte."""
    return -sum(data) & 0xFF


def points(data: bytes, count: int, at: int = 0) -> Taxels:
    """Return (count, 3) forces [N]."""
    table = np.frombuffer(data, POINT, count, at)
    return np.column_stack((table["xy"].astype(np.float64), table["z"])) * NEWTON


class _PaxiniDecoder(Decoder):
    """What both boards share: a start, a length, a check byte at the end."""

    start: bytes
    head: int

    def _next(self, over: bool) -> Found | None:
        data = self._buffer
        at = data.find(self.start)
        if at < 0:
            at = len(data) - data.endswith(self.start[:1])
        if at:
            return Found(at)
        if len(data) < self.head:
            return Found(len(self.start)) if over else None  # a stump, with nothing to come that would complete it
        length = self._length(bytes(data[: self.head]))
        if length is None:
            return Found(1)
        if len(data) < length:
            return Found(1) if over else None
        packet = bytes(data[:length])
        if lrc(packet[:-1]) != packet[-1]:
            self.counts.bad_checksum += 1
            return Found(1)
        values = self._values(packet)
        if values is None:
            self.counts.unfit += 1
            return Found(length)
        return Found(0, length, Reading(values, self._begin + length))

    def _length(self, head: bytes) -> int | None:
        raise NotImplementedError

    def _values(self, packet: bytes) -> Taxels | None:
        raise NotImplementedError


class PushDecoder(_PaxiniDecoder):
    """Decodes frames of the high-speed board."""

    start, head = PUSH, 5

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels, self._resultant = options.taxels, RESULTANT * resultant(options)

    def _length(self, head: bytes) -> int | None:
        (length,) = struct.unpack_from("<H", head, 3)
        return length + 6 if head[2] == 0 and 1 <= length <= LONGEST else None

    def _values(self, packet: bytes) -> Taxels | None:
        data, at, boards = packet[6:-1], 0, []
        if len(data) != sum(3 * count + self._resultant for count in self._taxels):
            return None
        for count in self._taxels:
            at += self._resultant
            boards.append(points(data, count, at))
            at += 3 * count
        return np.concatenate(boards)


class AnswerDecoder(_PaxiniDecoder):
    """Decodes answers of the serial converter board to the request for one module's points."""

    start, head = ANSWER, 13

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels = one_module(options)

    def _length(self, head: bytes) -> int | None:
        length, *fixed, dlen = struct.unpack("<HBBBIH", head[2:])
        return length + 5 if tuple(fixed) == READ_POINTS and length == dlen + 10 <= LONGEST else None

    def _values(self, packet: bytes) -> Taxels | None:
        return points(packet, self._taxels, 14) if len(packet) == 15 + 3 * self._taxels else None


class PushEncoder(Encoder):
    """Encodes frames of the high-speed board."""

    def __init__(self, options: Options) -> None:
        self._resultant = resultant(options)

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one push frame of all modules."""
        data = b""
        for values in boards:
            if self._resultant:
                data += np.clip(np.rint(values.sum(0) / NEWTON), -(2**15), 2**15 - 1).astype("<i2").tobytes()
            data += encode_points(values)
        packet = PUSH + b"\0" + struct.pack("<HB", len(data) + 1, 0) + data
        return packet + bytes([lrc(packet)])


class AnswerEncoder(Encoder):
    """Encodes answers of the serial converter board."""

    def __init__(self, options: Options) -> None:
        one_module(options)

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return the answer with the points of the only module."""
        data = encode_points(boards[0])
        packet = ANSWER + struct.pack("<HBBBIHB", len(data) + 10, *READ_POINTS, len(data), 1) + data
        return packet + bytes([lrc(packet)])


def encode_points(values: Taxels) -> bytes:
    """Return the points' bytes, forces out of range clipped."""
    whole = np.rint(np.nan_to_num(values) / NEWTON)
    table = np.zeros(len(values), POINT)
    table["xy"], table["z"] = np.clip(whole[:, :2], -128, 127), np.clip(whole[:, 2], 0, 255)
    return table.tobytes()


def request(function: int, register: int, data: bytes = b"", high_speed: bool = True, count: int = 0) -> bytes:
    """Return a request to either board: read, write or calibrate."""
    if high_speed:
        packet = struct.pack("<HBBHH", 0xAA55, 0, function, register, len(data)) + data
    else:
        packet = struct.pack("<HHBBBIH", 0xAA55, 9 + len(data), 1, 0, function, register, count or len(data)) + data
    return packet + bytes([lrc(packet)])


def resultant(options: Options) -> bool:
    """Return the option: whether pushed data hold resultants."""
    found = options.extra.get("resultant", True)
    if not isinstance(found, bool):
        raise InputError(f"paxini-fast: resultant = {found!r}, true or false wanted")
    return found


def one_module(options: Options) -> int:
    """Return the taxels of the only module."""
    if len(options.taxels) != 1:
        raise InputError(f"paxini-serial: {len(options.taxels)} arrays; this board has 1")
    return options.taxels[0]


def _push_talk(options: Options) -> Talk:
    types = request(0x10, 0x0016, bytes([2 + resultant(options)]))
    return Talk(hello=types + request(0x10, 0x0017, b"\1"))


def _answer_talk(options: Options) -> Talk:
    return Talk(poll=request(0xFB, 0x40E, high_speed=False, count=3 * one_module(options)), period=1 / 176)


FORMATS = {
    "paxini-fast": Format(
        "paxini-fast",
        "Paxini PX-6AX GEN3 on the high-speed board",
        "N",
        921600,
        True,
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
        "N",
        921600,
        True,
        5.0,
        AnswerDecoder,
        AnswerEncoder,
        _answer_talk,
        (),
        True,
    ),
}
