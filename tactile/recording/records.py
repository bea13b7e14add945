"""Records of an MCAP file, each held against the check sum that covers it.

A file that was closed in good order has sums over every chunk, over the whole data section and over the summary, so
that no changed bit stays unseen. In one that was broken off the chunks have theirs, and `schema.sum_of` covers what
stands before them.
"""

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import lz4.frame  # type: ignore[import-untyped]  # it ships no types
import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk, DataEnd, Footer
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from cnnsim.support import InputError
from cnnsim.support.limits import CHUNK, RECORD, check_plain

MAGIC = b"\x89MCAP0\r\n"
BROKEN = (McapError, CRCValidationError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError,
          RuntimeError)  # fmt: skip
"""What the libraries raise at damage; lz4 says RuntimeError."""

DATA_END = 4
"""Bytes of the record at the end of the data, whose own head is the one thing that no sum covers."""


@dataclass(frozen=True)
class Damage:
    """Stands where something could not be read or its sum was wrong; ``what`` in words."""

    what: str


@dataclass(frozen=True)
class Closed:
    """Stands at the end of a file that was closed in good order; `Damage` before it may have spoilt it since."""


def records(path: Path) -> Iterator[Any]:
    """Yield the records of an MCAP file, those of chunks in their places, up to its end or where it breaks off.

    Raises:
        InputError: it cannot be opened, or is no plain file.
    """
    try:
        check_plain(path, "recording")
        with path.open("rb") as file:
            yield from _records(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error


def _records(file: IO[bytes]) -> Iterator[Any]:
    size, summed = os.fstat(file.fileno()).st_size, False
    stream = StreamReader(file, emit_chunks=True, validate_crcs=True, record_size_limit=RECORD).records
    while True:
        at = file.tell()
        try:
            record = next(stream, None)
        except CRCValidationError:
            yield Damage("the sum over all data is wrong")
            return
        except BROKEN:
            if _has_end(file, size):
                yield Damage(f"what begins at byte {at} cannot be read")
            return  # else the writer was stopped here
        if record is None:
            break
        if isinstance(record, DataEnd):
            summed = record.data_section_crc != 0
            if _length(file, at) != DATA_END:
                yield Damage(f"what begins at byte {at} is not as long as it says")
        elif isinstance(record, Footer) and not (summed and _summary_is_right(file, record, size)):
            yield Damage("the sum over the index at the end is wrong")
        yield from _inside(record, at) if isinstance(record, Chunk) else [record]
    if file.tell() == size:
        yield Closed()


def _inside(chunk: Chunk, at: int) -> list[Any]:
    try:
        return breakup_chunk(replace(chunk, compression="", data=_unpacked(chunk)), validate_crc=True)
    except BROKEN as error:
        return [Damage(f"the chunk at byte {at} is left out: {error}")]


def _unpacked(chunk: Chunk) -> bytes:
    if chunk.uncompressed_size > CHUNK:
        raise ValueError(f"{chunk.uncompressed_size} bytes; at most {CHUNK} wanted")
    if chunk.compression == "zstd":
        if zstandard.frame_content_size(chunk.data) not in (chunk.uncompressed_size, -1):
            raise ValueError("its packed data are of another size")
        data = zstandard.decompress(chunk.data, chunk.uncompressed_size)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, chunk.uncompressed_size)
    elif not chunk.compression:
        data = chunk.data
    else:
        raise ValueError(f"packed as {chunk.compression!r}; zstd or lz4 wanted")
    if len(data) != chunk.uncompressed_size or not chunk.uncompressed_crc:
        raise ValueError("its size is wrong, or it has no sum")
    return data


def _length(file: IO[bytes], at: int) -> int:
    """Return how long the record that begins there says that it is; the file stays at its place."""
    back = file.tell()
    file.seek(at + 1)
    length = int.from_bytes(file.read(8), "little")
    file.seek(back)
    return length


def _has_end(file: IO[bytes], size: int) -> bool:
    """Return whether the file ends as one that was closed."""
    file.seek(max(0, size - len(MAGIC)))
    return size > 2 * len(MAGIC) and file.read() == MAGIC


def _summary_is_right(file: IO[bytes], footer: Footer, size: int) -> bool:
    """Return whether the sum over the summary is right: from its start up to itself; the file stays at its place."""
    at, left, total = file.tell(), size - len(MAGIC) - 4 - footer.summary_start, 0
    if not 0 < footer.summary_start < at:
        return False
    file.seek(footer.summary_start)
    while left > 0 and (data := file.read(min(left, 2**20))):
        total, left = zlib.crc32(data, total), left - len(data)
    file.seek(at)
    return total == footer.summary_crc
