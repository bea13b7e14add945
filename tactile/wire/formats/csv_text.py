"""CSV text lines: one line of numbers per frame, from any device that prints them.

    [sequence,][time,]x0,y0,z0,x1,y1,z1,...[,skipped][*HH] LF or CR LF

Separators are commas, semicolons, tabs or spaces; one at the end, brackets and labels (``X0: 1.5``) are ignored. Option
``before`` names the columns before the taxels: "sequence", "t_us", "t_ms", "t_s", or "-" and any text for one that is
skipped, as ``after`` names those after them. With a table [layout] in the array file the board prints a header line
first, in which the layout finds its columns, as in that of a recording. A cell that is no number, such as ``nan``,
``inf``, ``ovf`` or an empty one, is a taxel without a reading. HH is an optional check byte: the exclusive or of all
bytes before the asterisk, in hexadecimal, as in NMEA 0183. Lines that begin with ``#``, and other text, are skipped.
The first line, which may be incomplete, is used if the next one is as long up to its first separator.

Changed digits in a line without HH are not detected. A jump of the sequence number in such a line is accepted when the
next line continues from it.
"""

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Encoder, Found, Options
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format

if TYPE_CHECKING:
    from tactile.layout.header_line import LineColumns

LONGEST, CELL, SHOWN = 65536, 32, 60
"""Longest line in bytes: at least this, and CELL bytes per number; bytes of a line that are shown."""
SPLIT = re.compile(rb"[ \t]*[,;][ \t]*|[ \t]+")
NUMBER = rb"(?:[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d{1,3})?|[nN][aA][nN])"
LABEL = re.compile(rb"[A-Za-z_][\w.\[\]-]*[ \t]*[:=][ \t]*")
BRACKETS = bytes.maketrans(b'[](){}<>"', b"         ")
BLANK = re.compile(rb"[+-]?(?:nan|inf(?:inity)?|ovf|ovl|ol|none|null|n/?a|err|-+)?", re.IGNORECASE)
"""Cells of a taxel without a reading. A line of other words is no frame."""
NUMBERS = re.compile(NUMBER + rb"(?:(?:" + SPLIT.pattern + rb")" + NUMBER + rb")*+")
NUMBER_ALONE = re.compile(NUMBER)
SECONDS = {"t_us": 1e-6, "t_ms": 1e-3, "t_s": 1.0}
BEFORE = ("sequence", *SECONDS, "-")


class CsvDecoder(Decoder):
    """Decodes lines with the taxels of all boards."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._before, self._axes = skipped_columns(options, "before"), options.axes
        self._taxels = options.axes * sum(options.taxels)
        self._count = len(self._before) + self._taxels
        self._after = len(skipped_columns(options, "after"))
        self._layout, self._headless, self._columns = options.layout, "", cast("LineColumns | None", None)
        if options.layout is not None:
            self._before, self._count, self._after = [], 0, 0
            self._headless = "no header line yet, in which the layout finds its columns: reset the board"
        self._longest = max(LONGEST, CELL * (self._count + self._after + 1))
        self._lines = 0
        self._restart()

    def _restart(self) -> None:
        self._first = True
        self._searched = 0  # bytes of the buffer in which no line ends

    def _next(self, over: bool) -> Found | None:
        end = self._buffer.find(b"\n", self._searched, self._longest)
        self._searched = 0
        if end < 0:
            if len(self._buffer) >= self._longest:
                return Found(self._longest)
            self._searched = len(self._buffer)
            return None
        line = bytes(self._buffer[:end]).strip()
        if self._first and line and not line.startswith(b"#"):
            following = self._buffer.find(b"\n", end + 1, self._longest)
            if following < 0 and not over and len(self._buffer) < self._longest:
                return None
            second = bytes(self._buffer[end + 1 : max(following, 0)]).strip()
            named = self._layout is not None and self._cells(line) is None
            if not named and (
                self._cells(second) is None or len(SPLIT.split(line, 1)[0]) < len(SPLIT.split(second, 1)[0])
            ):
                line = b""
        self._first = False
        self._lines += 1
        if self._layout is not None and self._read_header(line):
            return Found(end + 1)
        if not line or line.startswith(b"#"):
            return Found(end + 1)
        body, star, check = line.partition(b"*")
        if star and check.upper() != check_byte(body):
            self.counts.bad_checksum += 1
            return Found(end + 1)
        numbers = self._cells(body)
        if numbers is None:
            return Found(end + 1)
        if self._headless:
            self._count_unfit(self._headless)
            return Found(end + 1)
        if len(numbers) != self._count + self._after:
            shown = body[:SHOWN].decode("ascii", "replace") + " ..." * (len(body) > SHOWN)
            wanted = self._count + self._after
            self._count_unfit(f"{len(numbers)} numbers in line {self._lines} ({wanted} wanted): {shown!r}")
            return Found(end + 1)
        return self._found(end + 1, numbers, bool(star))

    def _cells(self, body: bytes) -> list[float] | None:
        """Return the values of a line, NaN for a cell that is no number; None for a line that is no row of values."""
        body = body.strip()
        if NUMBERS.fullmatch(body):  # parsing the whole line is five times faster than each number
            only_commas = len(body.translate(None, b"; \t")) == len(body)
            cells = body.split(b",") if only_commas else SPLIT.split(body)
            if len(cells) == self._count + self._after or not body.endswith(b","):
                numbers = list(map(float, cells))
                return (
                    numbers if math.isfinite(sum(numbers)) else [x if math.isfinite(x) else math.nan for x in numbers]
                )
        cells = SPLIT.split(LABEL.sub(b"", body).translate(BRACKETS).strip())
        if len(cells) > self._count + self._after and not cells[-1]:
            cells.pop()
        known = [bool(NUMBER_ALONE.fullmatch(cell)) for cell in cells]
        words = sum(not one and not BLANK.fullmatch(cell) for one, cell in zip(known, cells, strict=True))
        if not body or 4 * words > len(cells) or not (any(known) or len(cells) == self._count + self._after):
            return None
        numbers = [float(cell) if one else math.nan for one, cell in zip(known, cells, strict=True)]
        return [one if math.isfinite(one) else math.nan for one in numbers]

    def _read_header(self, line: bytes) -> bool:
        """Return whether a line is the header line, and keep the columns in which the layout finds its readings."""
        cells = SPLIT.split(line.lstrip(b"#%/ \t").rstrip(b",; \t"))
        if self._layout is None or len(cells) < self._taxels or any(map(NUMBER_ALONE.fullmatch, cells)):
            return False
        from tactile.layout.header_line import line_columns  # it imports the array descriptions

        try:
            self._columns = line_columns([cell.decode("utf-8", "replace").strip("\"'") for cell in cells], self._layout)
        except InputError as error:
            if self._columns is None:
                self._headless = f"no header line that fits the layout: {error}"
            return False
        self._count, self._headless = self._columns.width, ""
        return True

    def _found(self, length: int, cells: list[float], checked: bool) -> Found:
        if self._columns is None:
            head = dict(zip(self._before, cells, strict=False))
            seconds = next((head[name] * scale for name, scale in SECONDS.items() if name in head), math.nan)
            sequence, taxels = head.get("sequence"), cells[len(self._before) : self._count]
        else:
            _, place, number, time, unit = self._columns
            seconds = math.nan if time is None else cells[time] * unit
            sequence, taxels = None if number is None else cells[number], np.array(cells)[place].tolist()
        if sequence is not None and not (sequence == sequence and sequence.is_integer() and 0 <= sequence < 2**32):
            return Found(length)
        values = np.array(taxels).reshape(-1, self._axes)
        count = None if sequence is None else int(sequence)
        return Found(0, length, Reading(values, self._begin + length, None, count, seconds, checked))


class CsvEncoder(Encoder):
    """Encodes lines; option ``check = true`` adds the check byte."""

    def __init__(self, options: Options) -> None:
        self._before, self._check = skipped_columns(options, "before"), bool(options.extra.get("check", False))

    def preamble(self) -> bytes:
        """Return a line of column names up to those of the first taxel."""
        return ",".join(["#", *self._before, "x0", "y0", "z0", "..."]).encode() + b"\r\n"

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one line."""
        head = dict.fromkeys(self._before, "0") | {"sequence": str(sequence % 2**32)}
        head |= {name: repr(t_device / scale) for name, scale in SECONDS.items()}
        head["t_us"] = str(round(t_device * 1e6))
        numbers = [repr(value) for values in boards for value in values.ravel().tolist()]
        body = ",".join([*(head[name] for name in self._before), *numbers]).encode()
        return body + (b"*" + check_byte(body) if self._check else b"") + b"\r\n"


def check_byte(body: bytes) -> bytes:
    """Return the exclusive or of all bytes, in hexadecimal."""
    return b"%02X" % int(np.bitwise_xor.reduce(np.frombuffer(body, np.uint8), initial=0))


def skipped_columns(options: Options, key: str) -> list[str]:
    """Return the option ``before`` or ``after``: names of the columns next to the taxels."""
    known = BEFORE if key == "before" else ("-",)
    names = options.extra.get(key, ["sequence", "t_us"] if key == "before" else [])
    if not isinstance(names, list) or not all(
        isinstance(name, str) and (name in known or name.startswith("-")) for name in names
    ):
        raise InputError(f"csv: {key} = {names!r}, a list of {', '.join(known)} (or -name, which is skipped) wanted")
    return names


FORMATS = {
    "csv": Format(
        "csv",
        "text lines of numbers",
        115200,
        None,
        CsvDecoder,
        CsvEncoder,
        keys=("before", "after", "check"),
        blanks=True,
        normal_alone=True,
    )
}
