"""Shards of an array that lies uncompressed in a Zarr store on a disk, read and written as the rows that they are.

Zarr itself copies a shard three times and takes a call for each chunk in it. A shard here is one whose chunks go over
all its columns: one after the other they are its rows as in memory, and the index behind them is always the same. What
Zarr reads from such a file is what was written, and what Zarr wrote elsewhere without shards can be read here as well.
Black and white takes a bit a cell: a shard has eight cells of a row in a byte, and rows of whole bytes.
"""

import math
import struct
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.supersteps.blocks import Area, Span, runs
from cnnsim.support import Array, InputError, Integers

ROWS = 256
"""The most rows of a chunk, the least that Zarr reads of a shard."""
SMALLEST = 256
"""Sides of chunks from which they are worth a file each, where somebody else chose them."""
STRETCH = 1 << 22
"""Bytes that are handed to the system at a time: they stay in the cache between the copy and the write."""


def create(
    group: Any, name: str, shape: tuple[int, ...], dtype: Any, side: int, *, bits: bool = False, fill: float = 0
) -> Any:
    """Make a Zarr array whose shards have ``side`` rows and columns of cells, an old one of that name gone.

    ``bits``: eight cells a byte; ``fill``: what cells hold of which nothing is written.
    """
    lead, part = shape[:-2], next(rows for rows in range(min(side, ROWS), 0, -1) if side % rows == 0)
    width = math.ceil(side / 8) if bits else side
    cols = width * math.ceil(shape[-1] / side) if bits else shape[-1]
    return group.create_array(
        name, shape=(*shape[:-1], cols), dtype=np.uint8 if bits else dtype, shards=(*lead, side, width),
        chunks=(*(1 for _ in lead), part, width), compressors=None, filters=None,
        fill_value=255 * (fill > 0) if bits else fill, overwrite=True, attributes={"rows": True, "bits": bits},
    )  # fmt: skip


def can_be_read(array: Any, dtype: np.dtype[Any]) -> bool:
    """Return whether a Zarr array lies on this machine's disk as numbers of this type, in files that are not tiny."""
    meta = array.metadata
    if not hasattr(array.store, "root") or meta.zarr_format != 3 or array.dtype != dtype:
        return False
    if array.attrs.get("rows"):
        return True
    bare = len(meta.codecs) == 1 and type(meta.codecs[0]).__name__ == "BytesCodec"
    large = all(part >= min(SMALLEST, cells) for part, cells in zip(array.chunks[-2:], array.shape[-2:], strict=True))
    return bare and large and array.chunks[:-2] == array.shape[:-2]


class Shards:
    """The files of such an array."""

    def __init__(self, array: Any) -> None:
        self.shape, self.dtype = tuple(array.shape), np.dtype(array.dtype)
        self.bits = bool(array.attrs.get("bits"))
        self._of = tuple(array.shards or array.chunks)
        self._folder, self._key = Path(array.store.root) / array.path, array.metadata.encode_chunk_key
        self._fill, self._trailer = array.fill_value, b""
        if array.shards:
            chunks = np.array(array.shards) // np.array(array.chunks)
            self._trailer = _index(int(chunks.prod()), int(np.prod(array.chunks)) * self.dtype.itemsize)

    @property
    def holds(self) -> np.dtype[Any]:
        """The type of a cell."""
        return np.dtype(bool) if self.bits else self.dtype

    @property
    def _size(self) -> tuple[int, int]:
        """Rows and columns of cells in a shard."""
        return self._of[-2], self._of[-2] if self.bits else self._of[-1]

    def cells(self, rows: Integers, cols: Integers, dtype: Any = None) -> Array:
        """Return the cells in these rows and columns; ``dtype``: of what is returned, as `read` has it."""
        out = np.empty((*self.shape[:-2], len(rows), len(cols)), self.holds if dtype is None else dtype)
        for (p0, p1), down in runs(rows, 0):
            for (q0, q1), across in runs(cols, 0):
                self.read(out[..., p0:p1, q0:q1], down, across)
        return out

    def read(self, out: Array, rows: Span, cols: Span) -> None:
        """Read the cells in these rows and columns; a file that is not there has the array's fill value.

        Black and white becomes +1 and -1 in an ``out`` of numbers.
        """
        side, width = self._size
        for i in range(rows[0] // side, -(-rows[1] // side)):
            p0, p1 = max(rows[0], i * side), min(rows[1], (i + 1) * side)
            for j in range(cols[0] // width, -(-cols[1] // width)):
                q0, q1 = max(cols[0], j * width), min(cols[1], (j + 1) * width)
                part = out[..., p0 - rows[0] : p1 - rows[0], q0 - cols[0] : q1 - cols[0]]
                try:
                    shard = self._mapped(self._file(i, j))
                except FileNotFoundError:
                    part[...] = _levels(np.bool_(self._fill), out.dtype) if self.bits else self._fill
                    continue
                except ValueError as error:
                    raise InputError(f"{self._file(i, j)} is cut short; a whole shard wanted") from error
                there = shard[..., p0 - i * side : p1 - i * side, :]
                first, after = q0 - j * width, q1 - j * width
                part[...] = _levels(_unpacked(there, first, after), out.dtype) if self.bits else there[..., first:after]

    def _mapped(self, file: Path) -> Array:
        """Return a shard as it lies in its file; `numpy.memmap` asks for the file's real path, which takes as long."""
        with file.open("rb") as stream:
            held = mmap(stream.fileno(), 0, access=ACCESS_READ)
        return np.frombuffer(held, self.dtype, math.prod(self._of)).reshape(self._of)

    def write(self, area: Area, values: Array) -> None:
        """Write one shard; beyond the end of the grid it has whatever it had."""
        (r0, r1), (c0, _) = area
        side, width = self._size
        file = self._file(r0 // side, c0 // width)
        file.parent.mkdir(parents=True, exist_ok=True)
        values, width = np.packbits(values, axis=-1) if self.bits else values, self._of[-1]
        item, whole = self.dtype.itemsize, values.shape[-1] == width
        strip = max(1, STRETCH // (width * item)) if whole else 1
        planes = values.reshape(-1, *values.shape[-2:])
        with file.open("r+b" if file.exists() else "w+b", buffering=0 if whole else STRETCH) as stream:
            for number, plane in enumerate(planes):
                for row in range(0, r1 - r0, strip):
                    stream.seek((number * side + row) * width * item)
                    _put(stream, plane[row : row + strip].astype(self.dtype, order="C", copy=False))
            stream.seek(len(planes) * side * width * item)
            _put(stream, self._trailer)

    def _file(self, i: int, j: int) -> Path:
        return self._folder / self._key((*(0 for _ in self.shape[:-2]), i, j))


def _unpacked(shard: Array, first: int, after: int) -> Array:
    """Return the bits of some columns of cells."""
    low = first // 8
    return np.unpackbits(shard[..., low : -(-after // 8)], axis=-1)[..., first - 8 * low : after - 8 * low]


def _levels(bits: Any, dtype: np.dtype[Any]) -> Any:
    return bits if dtype.kind == "b" else np.where(bits, dtype.type(1), dtype.type(-1))


def _put(stream: Any, what: Any) -> None:
    """Write all: a stream without a buffer may take a part of it."""
    left = memoryview(what).cast("B")
    while left:
        left = left[stream.write(left) :]


def _index(chunks: int, size: int) -> bytes:
    """Return the index at the end of a shard: where each chunk is and its bytes, then their checksum."""
    from google_crc32c import value  # Zarr's own, so it is there where Zarr is

    places = b"".join(struct.pack("<QQ", number * size, size) for number in range(chunks))
    return places + struct.pack("<I", value(places))
