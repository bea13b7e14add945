"""Gigabytes of zeros packed into kilobytes, without packing gigabytes: the parts of which such streams are made."""

import struct
import zlib

_PIECE = 10_000_000


def deflated(count: int, head: bytes = b"") -> bytes:
    """Return a raw deflate stream of ``head`` and a number of zeros, rounded down to ten millions."""
    first = zlib.compressobj(9, wbits=-15)
    begin = first.compress(head) + first.flush(zlib.Z_FULL_FLUSH)
    piece = zlib.compressobj(9, wbits=-15)
    zeros = piece.compress(bytes(_PIECE)) + piece.flush(zlib.Z_FULL_FLUSH)
    return begin + zeros * (count // _PIECE) + piece.flush()


def zlib_zeros(count: int) -> bytes:
    """Return a zlib stream of a number of zeros, a multiple of ten millions, with its checksum."""
    return b"\x78\xda" + deflated(count) + struct.pack(">I", (count % 65521) << 16 | 1)


def zipped(name: str, count: int, head: bytes) -> bytes:
    """Return an archive of one member, ``head`` and a number of zeros; its checksum, read at its end, is wrong."""
    data = deflated(count, head)
    size = len(head) + count // _PIECE * _PIECE
    about = struct.pack("<HHHHHIIIHH", 20, 0, 8, 0, 33, 0, len(data), size, len(name), 0)
    local = b"PK\x03\x04" + about + name.encode() + data
    entry = b"PK\x01\x02" + struct.pack("<H", 20) + about + struct.pack("<HHHII", 0, 0, 0, 0, 0) + name.encode()
    return local + entry + b"PK\x05\x06" + struct.pack("<HHHHIIH", 0, 0, 1, 1, len(entry), len(local), 0)


def zstd_zeros(count: int) -> bytes:
    """Return a Zstandard frame of a number of zeros, rounded up to 128 KiB: blocks of a repeated byte (RFC 8878)."""
    blocks = -(-count // (1 << 17))
    head = 1 << 20 | 1 << 1  # size << 3 | kind << 1 | last
    block, last = ((head | end).to_bytes(3, "little") + b"\0" for end in (0, 1))
    return b"\x28\xb5\x2f\xfd\x00" + bytes([7 << 3]) + block * (blocks - 1) + last
