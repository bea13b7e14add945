"""Records of an MCAP file, each verified by its checksum.

A closed file has checksums over every chunk, the data section and the summary. An interrupted file has those of its
chunks, and `schema.sum_of` covers the metadata before them.
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
"""Exceptions of the libraries for damaged data; lz4 raises RuntimeError."""

DATA_END = 4
"""Bytes of the record at the end of the data; its header has no checksum."""


@dataclass(frozen=True)
class Damage:
    """Marks an unreadable part or a wrong checksum; ``what`` describes it."""

    what: str


@dataclass(frozen=True)
class Closed:
    """Marks the end of a file that was closed; `Damage` may precede it."""


def records(path: Path) -> Iterator[Any]:
    """Yield the records of an MCAP file, including those in chunks, up to its end or where it breaks off.

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
            return  # otherwise the writer was stopped here
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
    """Return the length that the record at this position states; the file position is kept."""
    back = file.tell()
    file.seek(at + 1)
    length = int.from_bytes(file.read(8), "little")
    file.seek(back)
    return length


def _has_end(file: IO[bytes], size: int) -> bool:
    """Return whether the file ends like a closed one."""
    file.seek(max(0, size - len(MAGIC)))
    return size > 2 * len(MAGIC) and file.read() == MAGIC


def _summary_is_right(file: IO[bytes], footer: Footer, size: int) -> bool:
    """Return whether the checksum of the summary is right; the file position is kept."""
    at, left, total = file.tell(), size - len(MAGIC) - 4 - footer.summary_start, 0
    if not 0 < footer.summary_start < at:
        return False
    file.seek(footer.summary_start)
    while left > 0 and (data := file.read(min(left, 2**20))):
        total, left = zlib.crc32(data, total), left - len(data)
    file.seek(at)
    return total == footer.summary_crc
