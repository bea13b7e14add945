"""Parquet recordings: one row per frame of one finger, the header of `tactile.core.header` as metadata.

Columns: ``t_s``, ``t_device_s`` (NaN where the device has no clock), ``finger`` (its name), ``sequence``, ``values``
(shear_x, shear_y, normal of every taxel, row by row, in the unit of the quantity), ``valid`` (one flag
a taxel) and ``flags`` of the device (`tactile.core.frame.FLAGS`; may be missing).
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from pyarrow import parquet  # type: ignore[import-untyped]  # it ships no types

from cnnsim.support.limits import check_plain, check_unpacked, one_line
from tactile.core.frame import MOST_FLAGS, Frame, TaxelArray
from tactile.core.header import header_text, read_header
from tactile.core.source import ForeignFileError, FrameStream, Source
from tactile.recording.parquet_rows import ParquetRows
from tactile.sources.stamps import in_order

KEY = b"tactile"
BATCH = 4096
"""Rows per batch."""
FIRST = 4
"""Rows per finger that are checked against the header when a file is opened."""
COLUMNS = {
    "t_s": float, "t_device_s": float, "finger": str, "sequence": int, "values": list[float], "valid": list[bool],
    "flags": int,
}  # fmt: skip


class ParquetFrames:
    """The frames of a Parquet file, read again each time; ``batch``: rows read at once."""

    def __init__(self, path: Path, arrays: tuple[TaxelArray, ...], batch: int = BATCH) -> None:
        self._path, self._arrays, self._batch = path, arrays, batch

    def __iter__(self) -> Iterator[Frame]:
        fingers = {array.name: number for number, array in enumerate(self._arrays)}
        row = 0
        with one_line(self._path, "a Parquet recording"), parquet.ParquetFile(self._path) as file:
            for batch in file.iter_batches(self._batch):
                for one in batch.to_pylist():
                    row += 1
                    with one_line(self._path, f"a frame in row {row}"):
                        frame = self._frame(one, fingers)
                    yield frame

    def _frame(self, row: dict[str, Any], fingers: dict[str, int]) -> Frame:
        finger = fingers[row["finger"]]
        shape = self._arrays[finger].shape
        given, wanted = (len(row["values"]), len(row["valid"])), (3 * shape[0] * shape[1], shape[0] * shape[1])
        if given != wanted:
            told = " x ".join(map(str, shape))
            raise ValueError(
                f"{given[0]} values and {given[1]} flags, {wanted[0]} and {wanted[1]} of {told} taxels wanted"
            )
        values = np.array(row["values"], dtype=np.float64).reshape(*shape, 3)
        valid = np.array(row["valid"], dtype=bool).reshape(shape)
        t, device, flags = float(row["t_s"]), float(row["t_device_s"]), int(row.get("flags") or 0)
        if not 0 <= flags <= MOST_FLAGS:
            raise ValueError(f"flags {flags}, from 0 to {MOST_FLAGS} wanted")
        return Frame(finger, t, int(row["sequence"]), values, valid, device, flags)


def read_parquet(path: Path) -> FrameStream:
    """Open a Parquet recording.

    Raises:
        InputError: no Parquet file, no header in it or a wrong one, other columns, first rows of other arrays, or times
            that step back and cannot be repaired.
    """
    check_plain(path, "recording")
    with one_line(path, "a Parquet recording"), parquet.ParquetFile(path) as file:
        schema, rows, groups = file.schema_arrow, file.metadata.num_rows, file.metadata.num_row_groups
        check_unpacked(path, sum(file.metadata.row_group(group).total_byte_size for group in range(groups)))
    text = (schema.metadata or {}).get(KEY)
    missing = [name for name in COLUMNS if name not in schema.names and name != "flags"]
    if text is None or missing:
        raise ForeignFileError(
            f"{path}: columns {', '.join(schema.names)}, {'a' if text is not None else 'no'} header; columns"
            f" {', '.join(COLUMNS)} and a header {KEY.decode()!r} in the metadata wanted"
        )
    header = read_header(text.decode(errors="replace"), str(path), "metadata tactile")
    first = FIRST * len(header.arrays)
    for _ in islice(ParquetFrames(path, header.arrays, first), first):  # before memory is allocated for these sizes
        pass
    frames = ParquetFrames(path, header.arrays)
    times = parquet.read_table(path, columns=["t_s"]).column(0).to_numpy()
    if not (np.diff(times) < 0).any():
        return header.stream(frames, rows)  # not all of them are in memory
    ordered, notes = in_order(list(frames), header.arrays, str(path))
    return replace(header.stream(ordered, rows), notes=notes)


def write_parquet(path: Path, source: Source) -> None:
    """Write all frames of a source; reading them back gives the same numbers bit for bit.

    Raises:
        InputError: two fingers have the same name.
        OSError: the file cannot be written.
    """
    with ParquetRows(path, COLUMNS, {KEY: header_text(source).encode()}) as out:
        for frame in source:
            name = source.arrays[frame.finger].name
            values, valid = frame.values.ravel(), frame.valid.ravel()
            out(frame.t, frame.t_device, name, frame.sequence, values, valid, frame.flags)
