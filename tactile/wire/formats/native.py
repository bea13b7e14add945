"""The native format, for your own firmware: COBS frames with a CRC-16, any rows x cols x 3.

One frame is the COBS code of the packet below, then one zero byte. Little endian, no padding:

    u8   version, 1           u8   board, from 0         u8 rows      u8 cols      so 255 x 255 taxels at most
    u8   kind of value: 0 = int16, 1 = float32
    u32  sequence number of this board, one more each frame
    u64  device time [us]
    rows * cols * 3 values: x, y, z of the first taxel, then of the next one along the row, ...
    u16  CRC-16/IBM-3740 of all bytes before (polynomial 0x1021, start 0xFFFF, not reflected)

Sources: S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Trans. Networking 7 (1999) 159; the CRC is
the standard library's ``binascii.crc_hqx``.
"""

import binascii
import struct
from collections.abc import Sequence

import numpy as np
from cobs import cobs  # type: ignore[import-untyped]  # it ships no types

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Encoder, Found, Options
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format

HEADER = struct.Struct("<BBBBBIQ")
CRC = struct.Struct("<H")
VERSION = 1
KINDS = (np.dtype("<i2"), np.dtype("<f4"))
SIDE, BOARDS = 255, 256
"""Largest numbers of rows or columns, and of boards, in the header."""
USUAL = 64 * 64
"""Frames of up to this number of taxels are decoded even if the description has fewer, and are counted as unfit."""


class NativeDecoder(Decoder):
    """Decodes native frames. A zero byte ends a frame and nothing else is one, so every fault costs one frame."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._shapes = options.shapes
        if len(self._shapes) > BOARDS or max(map(max, self._shapes)) > SIDE:
            rows, cols = max(self._shapes, key=max)
            raise InputError(
                f"native: {len(self._shapes)} boards of up to {rows} x {cols} taxels; {BOARDS} boards of"
                f" {SIDE} x {SIDE} at most wanted, since a frame's header has one byte for each"
            )
        self._longest = _longest(max(USUAL, *options.taxels))
        self._restart()

    def _restart(self) -> None:
        self._searched = 0  # bytes of the buffer without a zero

    def _next(self, over: bool) -> Found | None:
        end = self._buffer.find(0, self._searched, self._longest)
        self._searched = 0
        if end < 0:
            if len(self._buffer) >= self._longest:
                return Found(self._longest)
            self._searched = len(self._buffer)
            return None
        if end == 0:  # a device may send a zero first, which ends any noise before it
            return Found(0, 1)
        try:
            packet = cobs.decode(bytes(self._buffer[:end]))
        except cobs.DecodeError:
            return Found(end + 1)
        if len(packet) < HEADER.size + CRC.size:
            return Found(end + 1)
        if binascii.crc_hqx(packet[: -CRC.size], 0xFFFF) != CRC.unpack_from(packet, len(packet) - CRC.size)[0]:
            self.counts.bad_checksum += 1
            return Found(end + 1)
        reading = self._read(packet, self._begin + end + 1)
        if reading is None:
            _, board, rows, cols, *_ = HEADER.unpack_from(packet)
            self._count_unfit(f"board {board} of {rows} x {cols} taxels")
            return Found(end + 1)
        return Found(0, end + 1, reading)

    def _read(self, packet: bytes, end: int) -> Reading | None:
        version, board, rows, cols, kind, sequence, micros = HEADER.unpack_from(packet)
        if version != VERSION or board >= len(self._shapes) or (rows, cols) != self._shapes[board] or kind > 1:
            return None
        if len(packet) != HEADER.size + rows * cols * 3 * KINDS[kind].itemsize + CRC.size:
            return None
        values = np.frombuffer(packet, KINDS[kind], rows * cols * 3, HEADER.size).astype(np.float64)
        return Reading(values.reshape(-1, 3), end, board, sequence, micros * 1e-6)


class NativeEncoder(Encoder):
    """Encodes native frames; option ``value``: "float32" or "int16"."""

    def __init__(self, options: Options) -> None:
        value = options.extra.get("value", "float32")
        if value not in ("float32", "int16"):
            raise InputError(f"native format: value = {value!r}, 'float32' or 'int16' wanted")
        self._shapes, self._kind = options.shapes, int(value == "float32")

    def preamble(self) -> bytes:
        """Return a zero, which ends any noise before it."""
        return b"\0"

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one frame for every board."""
        return b"".join(self._one(n, values, sequence, t_device) for n, values in enumerate(boards))

    def _one(self, board: int, values: Taxels, sequence: int, t_device: float) -> bytes:
        kind, (rows, cols) = KINDS[self._kind], self._shapes[board]
        if self._kind == 0:
            values = np.rint(np.clip(np.nan_to_num(values), -(2**15), 2**15 - 1))
        micros = round(t_device * 1e6)
        head = HEADER.pack(VERSION, board, rows, cols, self._kind, sequence % 2**32, micros)
        packet = head + values.astype(kind).tobytes()
        return cobs.encode(packet + CRC.pack(binascii.crc_hqx(packet, 0xFFFF))) + b"\0"


def _longest(taxels: int) -> int:
    """Return the length [bytes] of a float32 frame of ``taxels`` taxels with the overhead of COBS."""
    packet = HEADER.size + taxels * 3 * 4 + CRC.size
    return packet + packet // 254 + 2


FORMATS = {
    "native": Format(
        "native",
        "COBS frames with CRC-16, sequence number and device time, for your own firmware",
        921600,
        None,
        NativeDecoder,
        NativeEncoder,
        keys=("value",),
    )
}
