"""CSV text lines: one line of numbers per frame, from any device that prints them.

    [sequence,][time,]x0,y0,z0,x1,y1,z1,...[*HH] LF or CR LF

Separators are commas, semicolons, tabs or spaces. Option ``before`` names the columns before the taxels: "sequence",
"t_us", "t_ms", "t_s", or "-" for an ignored one. ``nan`` marks a taxel without a reading. HH is an optional check byte:
the exclusive or of all bytes before the asterisk, in hexadecimal, as in NMEA 0183. Lines that begin with ``#``, and
other text, are skipped. The first line is skipped, because it may be incomplete.

Changed digits in a line without HH are not detected. A jump of the sequence number in such a line is accepted when the
next line continues from it.
"""

import math
import re
from collections.abc import Sequence

import numpy as np

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Encoder, Found, Options
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format

LONGEST, CELL = 65536, 32
"""Longest line in bytes: at least this, and CELL bytes per number."""
SPLIT = re.compile(rb"[ \t]*[,;][ \t]*|[ \t]+")
NUMBER = rb"(?:[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d{1,3})?|[nN][aA][nN])"
NUMBERS = re.compile(NUMBER + rb"(?:(?:" + SPLIT.pattern + rb")" + NUMBER + rb")*+")
SECONDS = {"t_us": 1e-6, "t_ms": 1e-3, "t_s": 1.0}
BEFORE = ("sequence", *SECONDS, "-")


class CsvDecoder(Decoder):
    """Decodes lines with the taxels of all boards."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._before, self._taxels = columns_before(options), sum(options.taxels)
        self._longest = max(LONGEST, CELL * (len(self._before) + 3 * self._taxels + 1))
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
        line, first = bytes(self._buffer[:end]).strip(), self._first
        self._first = False
        if first or not line or line.startswith(b"#"):
            return Found(end + 1)
        body, star, check = line.partition(b"*")
        if star and check.upper() != check_byte(body):
            self.counts.bad_checksum += 1
            return Found(end + 1)
        body = body.strip()
        if not NUMBERS.fullmatch(body):  # parsing the whole line is five times faster than each number
            return Found(end + 1)
        only_commas = len(body.translate(None, b"; \t")) == len(body)
        cells = body.split(b",") if only_commas else SPLIT.split(body)
        wanted = len(self._before) + 3 * self._taxels
        if len(cells) != wanted:
            self._count_unfit(f"{len(cells)} numbers in a line ({wanted} wanted)")
            return Found(end + 1)
        numbers = list(map(float, cells))
        if not math.isfinite(sum(numbers)) and math.inf in map(abs, numbers):  # such as 1e999
            return Found(end + 1)
        return self._found(end + 1, numbers, bool(star))

    def _found(self, length: int, cells: list[float], checked: bool) -> Found:
        head = dict(zip(self._before, cells, strict=False))
        seconds = next((head[name] * scale for name, scale in SECONDS.items() if name in head), math.nan)
        sequence = head.get("sequence")
        if sequence is not None and not (sequence.is_integer() and 0 <= sequence < 2**32):
            return Found(length)
        values = np.array(cells[len(self._before) :]).reshape(-1, 3)
        count = None if sequence is None else int(sequence)
        return Found(0, length, Reading(values, self._begin + length, None, count, seconds, checked))


class CsvEncoder(Encoder):
    """Encodes lines; option ``check = true`` adds the check byte."""

    def __init__(self, options: Options) -> None:
        self._before, self._check = columns_before(options), bool(options.extra.get("check", False))

    def preamble(self) -> bytes:
        """Return a line of column names up to those of the first taxel."""
        return ",".join(["#", *self._before, "x0", "y0", "z0", "..."]).encode() + b"\r\n"

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one line."""
        head = {"sequence": str(sequence % 2**32), "-": "0"}
        head |= {name: repr(t_device / scale) for name, scale in SECONDS.items()}
        head["t_us"] = str(round(t_device * 1e6))
        numbers = [repr(value) for values in boards for value in values.ravel().tolist()]
        body = ",".join([*(head[name] for name in self._before), *numbers]).encode()
        return body + (b"*" + check_byte(body) if self._check else b"") + b"\r\n"


def check_byte(body: bytes) -> bytes:
    """Return the exclusive or of all bytes, in hexadecimal."""
    return b"%02X" % int(np.bitwise_xor.reduce(np.frombuffer(body, np.uint8), initial=0))


def columns_before(options: Options) -> list[str]:
    """Return the option ``before``."""
    before = options.extra.get("before", ["sequence", "t_us"])
    if not isinstance(before, list) or not all(name in BEFORE for name in before):
        raise InputError(f"csv: before = {before!r}, a list of {', '.join(BEFORE)} wanted")
    return before


FORMATS = {
    "csv": Format(
        "csv",
        "text lines of numbers",
        115200,
        None,
        CsvDecoder,
        CsvEncoder,
        keys=("before", "check"),
        blanks=True,
    )
}
