"""Packets, points and options of both Paxini PX-6AX GEN3 boards.

Little endian; LRC is the two's complement of the sum of all bytes before it; a point is int8 Fx, int8 Fy, uint8 Fz in
0.1 N, Fz positive when pressed.

    high-speed board
        request  55 AA | 00 | fc | u16 register | u16 dlen | data | LRC
        reply    AA 55 | 00 | fc | u16 register | u16 dlen | data | LRC                                   dlen + 9 bytes
        push     AA 56 | 00 | u16 FL | u8 error | FL - 1 bytes of data | LRC                               FL + 6 bytes
    serial converter board
        request  55 AA | u16 len | dev 01 | 00 | fc | u32 address | u16 dlen | data | LRC
        answer   AA 55 | u16 len | dev 01 | 00 | fc | u32 address | u16 dlen | u8 status | data | LRC     len + 5 bytes

A write's answer has no data, though dlen repeats the request's. Functions: 03 read, 10 write, 17 calibrate on the
high-speed board; FB read force, 79 calibrate on the other.

Source: paxini-sdk 0.1.0 ``protocol.py``, ``registers.py``, ``boards``.
"""

import struct

import numpy as np

from cnnsim.support import InputError
from tactile.wire.base import Options
from tactile.wire.reading import Taxels

NEWTON = 0.1
POINT = np.dtype([("xy", "i1", 2), ("z", "u1")])
RESULTANT = 6
REQUEST, REPLY, PUSH = bytes.fromhex("55aa"), bytes.fromhex("aa55"), bytes.fromhex("aa56")
FAST = struct.Struct("<BBHH")
"""reserved, function, register, dlen."""
SLOW = struct.Struct("<HBBBIH")
"""len, device, reserved, function, address, dlen."""
READ, WRITE, CALIBRATE = 0x03, 0x10, 0x17
READ_FORCE, CALIBRATE_ONE = 0xFB, 0x79
MODULES, DATA_TYPE, AUTO_PUSH, POINT_COUNTS, ZERO = 0x0010, 0x0016, 0x0017, 0x0030, 0x0002
"""Registers of the high-speed board: module bitmap, kinds of data (1 resultant, 2 points), push, points, calibrate."""
POINTS_ADDRESS, ZERO_ADDRESS = 0x40E, 0x03
"""Addresses of the serial converter board."""
LONGEST = 2048
"""Bytes of data to wait for beyond those of the modules, so that other shapes are recognised."""
SLOTS, LARGEST = 28, 2**16 - 16
"""Modules of the high-speed board; largest number of data bytes for a 16-bit length."""


def lrc(data: bytes | bytearray) -> int:
    """Return the check byte."""
    return -sum(data) & 0xFF


def closed(packet: bytes) -> bytes:
    """Return the packet with its check byte."""
    return packet + bytes([lrc(packet)])


def points(data: bytes, count: int, at: int = 0) -> Taxels:
    """Return (count, 3) forces [N]."""
    table = np.frombuffer(data, POINT, count, at)
    return np.column_stack((table["xy"].astype(np.float64), table["z"])) * NEWTON


def encode_points(values: Taxels) -> bytes:
    """Return the points' bytes, forces out of range clipped."""
    whole = np.rint(np.nan_to_num(values) / NEWTON)
    table = np.zeros(len(values), POINT)
    table["xy"], table["z"] = np.clip(whole[:, :2], -128, 127), np.clip(whole[:, 2], 0, 255)
    return table.tobytes()


def fast_request(function: int, register: int, data: bytes = b"") -> bytes:
    """Return a request to the high-speed board."""
    return closed(REQUEST + FAST.pack(0, function, register, len(data)) + data)


def slow_request(function: int, address: int, data: bytes = b"", count: int = 0) -> bytes:
    """Return a request to the serial converter board; a read asks for ``count`` bytes."""
    return closed(REQUEST + SLOW.pack(9 + len(data), 1, 0, function, address, count or len(data)) + data)


def resultant(options: Options) -> bool:
    """Return the option ``resultant``: whether pushed data contain resultants."""
    found = options.extra.get("resultant", True)
    if not isinstance(found, bool):
        raise InputError(f"paxini-fast: resultant = {found!r}, true or false wanted")
    return found


def longest(data: int) -> int:
    """Return the longest packet to wait for if the modules send ``data`` bytes.

    Raises:
        InputError: more than a packet can hold.
    """
    if data > LARGEST:
        raise InputError(f"paxini: {data} bytes of points in a packet; {LARGEST} at most wanted: fewer taxels")
    return max(LONGEST, data + 16)


def one_module(options: Options) -> int:
    """Return the taxels of the only module."""
    if len(options.taxels) != 1:
        raise InputError(f"paxini-serial: {len(options.taxels)} arrays; this board has 1, one [[finger]] wanted")
    return options.taxels[0]
