"""CSV recordings: one line per frame of one finger.

The file begins with the header of `tactile.core.header` as comment lines:

    # tactile_recording = 1
    # title = "grip"
    # [[finger]]
    # name = "left"
    # ...

Then a line of column names and the frames, ordered in time (else their stamps are repaired, with a notice):

    t_s,t_device_s,finger,sequence,flags,x0,y0,n0,x1,y1,n1,...

flags are the bits of `tactile.core.frame.FLAGS`; the column is optional. x, y, n are shear_x,
shear_y and normal of taxel row * cols + col. A finger with fewer taxels has shorter lines. An empty or NaN cell makes
the taxel invalid; ``t_device_s`` is empty where the device has no clock.
"""

import csv
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TextIO

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.errors import SHOWN, cut
from cnnsim.support.limits import LABELS, TABLE, check_file, one_line
from tactile.core.frame import MOST_FLAGS, Frame, TaxelArray
from tactile.core.header import header_text, read_header
from tactile.core.source import ForeignFileError, FrameStream, Source
from tactile.sources.stamps import in_order

FIXED_COLUMNS = ("t_s", "t_device_s", "finger", "sequence", "flags")


def read_csv(path: Path) -> FrameStream:
    """Read a recording.

    Raises:
        InputError: no such file, or a line that is incomplete or inconsistent with the header; the message names
            file, line and what is expected; stamps that step back, without another clock.
    """
    with one_line(path, "a CSV recording"):
        check_file(path, "recording", TABLE)
        with path.open(encoding="utf-8-sig") as file:
            return _read(path, _lines(file))


def _lines(file: TextIO) -> Iterator[str]:
    """Yield the lines of a file without the empty ones at its end."""
    empty = 0
    while line := file.readline(LABELS):
        if len(line) == LABELS:
            raise InputError(f"{file.name}: a line of more than {LABELS} characters")
        if line == "\n":
            empty += 1
            continue
        yield from ("\n",) * empty
        empty = 0
        yield line


def _read(path: Path, lines: Iterator[str]) -> FrameStream:
    comments, line = [], next(lines, "")
    while line.startswith("#"):
        comments.append(line[1:].lstrip())
        line = next(lines, "")
    if not any(comment.startswith("tactile_recording") for comment in comments):
        raise ForeignFileError(f"{path}: no header of a recording")
    head = read_header("".join(comments), str(path), "the comment lines at the top")
    arrays, start = head.arrays, len(comments)
    rows = csv.reader(chain([line] if line else [], lines))
    names = next(rows, None)
    fixed = FIXED_COLUMNS if names is None or "flags" in names else FIXED_COLUMNS[:-1]
    most = max(array.rows * array.cols for array in arrays)
    count = len(fixed) + 3 * most
    if names is None or len(names) != count or names != _columns(most, fixed):
        got = cut(line.rstrip("\n")) if line else "the end of the file"
        wanted = cut(",".join(_columns(min(most, SHOWN), fixed)))
        many = "" if names is None or len(names) == count else f": {count}, not {len(names)}"
        raise InputError(f"{path}, line {start + 1}: {got!r}, the column names {wanted!r} wanted{many}")
    frames: list[Frame] = []
    for row in rows:
        where = f"{path}, line {start + rows.line_num}"
        frames.append(_read_frame(row, arrays, fixed, where))
    if not frames:
        raise InputError(f"{path}: no frames after the column names, at least one wanted")
    ordered, notes = in_order(frames, arrays, str(path))
    return replace(head.stream(ordered, len(frames)), notes=notes)


def write_csv(path: Path, source: Source) -> None:
    """Write all frames of a source; reading them back gives the same numbers bit for bit.

    Invalid taxels become empty cells, without their reading.

    Raises:
        InputError: two fingers have the same name.
        OSError: the file cannot be written.
    """
    names = [array.name for array in source.arrays]
    header = header_text(source).rstrip("\n").split("\n")
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {line}\n" for line in header)
        out = csv.writer(file, lineterminator="\n")
        out.writerow(_columns(max(array.rows * array.cols for array in source.arrays)))
        for frame in source:
            values = np.where(frame.valid[..., None], frame.values, np.nan).ravel().tolist()
            cells = [_cell(value) for value in (frame.t, frame.t_device, *values)]
            out.writerow([*cells[:2], names[frame.finger], frame.sequence, frame.flags, *cells[2:]])


def _columns(taxels: int, fixed: tuple[str, ...] = FIXED_COLUMNS) -> list[str]:
    return [*fixed, *(f"{axis}{taxel}" for taxel in range(taxels) for axis in "xyn")]


def _cell(value: float) -> str:
    return "" if np.isnan(value) else repr(value)


def _read_frame(row: list[str], arrays: tuple[TaxelArray, ...], fixed: tuple[str, ...], where: str) -> Frame:
    names = [array.name for array in arrays]
    if len(row) < len(fixed):
        raise InputError(f"{where}: {len(row)} columns, at least {len(fixed)} wanted")
    if row[2] not in names:
        raise InputError(f"{where}: finger {row[2]!r}, one of {', '.join(names)} wanted")
    finger = names.index(row[2])
    array = arrays[finger]
    count = len(fixed) + 3 * array.rows * array.cols
    if len(row) != count:
        raise InputError(f"{where}: {len(row)} columns, {count} wanted for finger {array.name!r}")
    sequence, flags = _whole(row[3], f"{where}: sequence"), 0
    if fixed == FIXED_COLUMNS:
        flags = _whole(row[4], f"{where}: flags")
        if not 0 <= flags <= MOST_FLAGS:
            raise InputError(f"{where}: flags {flags}, from 0 to {MOST_FLAGS} wanted")
    columns = _columns(array.rows * array.cols, fixed)
    t, t_device, *flat = (_number(row[i], f"{where}: {columns[i]}") for i in (0, 1, *range(len(fixed), count)))
    if not np.isfinite(t):
        raise InputError(f"{where}: t_s = {row[0]!r}, a finite time wanted")
    values = np.array(flat).reshape(*array.shape, 3)
    return Frame(finger, t, sequence, values, np.isfinite(values).all(-1), t_device, flags)


def _whole(cell: str, where: str) -> int:
    try:
        return int(cell)
    except ValueError as error:
        raise InputError(f"{where} {cell!r}, a whole number wanted") from error


def _number(cell: str, where: str) -> float:
    try:
        return float(cell) if cell.strip() else float("nan")
    except ValueError as error:
        raise InputError(f"{where} = {cell!r}, a number or nothing wanted") from error
