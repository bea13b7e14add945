"""Read matrices and function lines of ``.tem`` files."""

import re
from dataclasses import dataclass, replace
from itertools import pairwise

from cnnsim.formats.candy.content import Call, FunctionLine, MatrixEntry
from cnnsim.formats.candy.lines import Line
from cnnsim.formats.numbers import is_number, number, whole
from cnnsim.support import Diagnostics, InputError

_CALL = re.compile(r"([A-Za-z]+)([-0]?)")
_ARGUMENT = re.compile(r"([xyu]\d?-[xyu]\d?)\s*#\s*([xyu]\d?-[xyu]\d?)?", re.I)
_NAME = re.compile(r"[A-Za-z]+:?")


@dataclass
class Cursor:
    """A position in the lines, and the report for errors."""

    lines: list[Line]
    report: Diagnostics
    at: int = 0

    def peek(self) -> Line | None:
        """Return the line that comes next."""
        return self.lines[self.at] if self.at < len(self.lines) else None

    def take(self) -> Line:
        """Return the next line and go on."""
        self.at += 1
        return self.lines[self.at - 1]


def is_function(line: Line, words_at_least: int = 3) -> bool:
    """Return whether a line is a function line: a letter, interpolation, a count, then numbers only.

    ``d 0 d`` is a row of a matrix and ``d 0 2  0.01 0.5  2.5 -0.5`` is a function. Where a row may come as well, a
    pair of numbers is wanted on the same line (``words_at_least`` 5): ``d 0 1`` is a row of NONLIN_D then.
    """
    words = line.words
    if (
        line.keyword
        or len(words) < words_at_least
        or not _NAME.fullmatch(words[0])
        or not all(map(is_number, words[1:]))
    ):
        return False
    return words[1] in ("0", "1") and (whole(words[2]) or 0) >= 1


def read_function(cursor: Cursor) -> FunctionLine | None:
    """Read a function line, and the lines of numbers that carry it on."""
    line = cursor.take()
    letter, kind, count, *values = line.words
    wanted = 2 * (whole(count) or 0)
    while len(values) < wanted and (more := cursor.peek()) and not more.keyword and all(map(is_number, more.words)):
        values += cursor.take().words
    if len(values) != wanted:
        cursor.report.error(line.number, f"function {letter!r}: {len(values)} numbers, {count} pairs announced")
        return None
    try:
        points = [number(word) for word in values]
    except InputError as error:
        cursor.report.error(line.number, f"function {letter!r}: {error}")
        return None
    pairs = tuple(zip(points[::2], points[1::2], strict=True))
    if any(later[0] <= earlier[0] for earlier, later in pairwise(pairs)):
        cursor.report.warning(line.number, f"function {letter!r}: its places do not ascend")
    return FunctionLine(letter.rstrip(":"), kind == "1", pairs, line.number)


def read_argument(cursor: Cursor) -> tuple[str, str]:
    """Read the line ``argument # factor`` that follows NONLIN_D."""
    line = cursor.peek()
    if line and not line.keyword and (match := _ARGUMENT.fullmatch(line.text)):
        cursor.take()
        return match[1].lower(), (match[2] or "").lower()
    given = "nothing" if line is None else repr(line.text[:40])
    cursor.report.error(
        line.number if line else None, f"NONLIN_D: {given} follows; a line such as 'x-u#' or 'x-x#x-x' wanted"
    )
    if line and "#" in line.text:
        cursor.take()
    return "", ""


def read_matrix(cursor: Cursor, heading: Line, first: str) -> tuple[tuple[MatrixEntry, ...], ...]:
    """Read the rows up to the next keyword or function line; () with an error if they are no odd square."""
    rows = [Line(heading.number, first)] if first else []
    while line := cursor.peek():
        side = len(rows[0].words) if rows else 0
        inside = len(rows) < side == len(line.words)
        complete = 0 < side == len(rows)
        stray = complete and side != len(line.words) and not is_number(line.words[0])
        function = is_function(line, 5 if heading.keyword == "NONLIN_D" and not complete else 3)
        if line.keyword or "#" in line.text or stray or (function and not inside):
            break
        rows.append(cursor.take())
    title = heading.keyword
    if not rows:
        cursor.report.error(heading.number, f"{title}: no matrix")
        return ()
    rows = [_with_point(line, _side(rows), title, cursor.report) for line in rows]
    entries = [_row(line, title, cursor.report) for line in rows]
    return () if None in entries or not _square(rows, title, cursor.report) else tuple(row for row in entries if row)


def _row(line: Line, title: str, report: Diagnostics) -> tuple[MatrixEntry, ...] | None:
    entries: list[MatrixEntry] = []
    for word in line.words:
        call = _CALL.fullmatch(word)
        if call and title.startswith("NONLIN") and (call[2] == "") == (title == "NONLIN_D"):
            entries.append(Call(call[1], call[2]))  # type: ignore[arg-type]  # the pattern allows these three only
            continue
        try:
            entries.append(number(word))
        except InputError as error:
            report.error(line.number, f"{title}: {error}" + (_wanted(title) if call else ""))
            return None
    return tuple(entries)


def _wanted(title: str) -> str:
    if title == "NONLIN_D":
        return "; in NONLIN_D a function is named by its letter alone"
    return "; a function is named as a- or a0" if title.startswith("NONLIN") else "; only NONLIN blocks take functions"


def _side(rows: list[Line]) -> int:
    """Return the number of columns that most rows have."""
    widths = [len(line.words) for line in rows]
    return max(set(widths), key=widths.count)


def _square(rows: list[Line], title: str, report: Diagnostics) -> bool:
    widths, side = [len(line.words) for line in rows], _side(rows)
    for line, width in zip(rows, widths, strict=True):
        if width != side:
            report.error(line.number, f"{title}: a row of {width} in a matrix of {side} columns")
    if set(widths) == {side} and (len(rows) != side or side % 2 == 0):
        report.error(rows[0].number, f"{title}: {len(rows)} rows of {side}; an odd square (3 x 3, 5 x 5, ...) wanted")
    return set(widths) == {side} and len(rows) == side and side % 2 == 1


def _with_point(line: Line, side: int, title: str, report: Diagnostics) -> Line:
    """Read ``0 0`` as the ``0.0`` it must have been, where a row of such numbers is too long by that one entry.

    ADCONT, ADCONTC and EDGEA have ``0.0  0 0  0.15 0.0  0.0``; read so, their matrices are symmetric. Nothing but
    zeros is mended: any other pair could be two entries.
    """
    pairs = re.findall(r"(?<!\S)0 0(?!\S)", line.text)
    if len(line.words) != side + 1 or len(pairs) != 1 or "0.0" not in line.words:
        return line
    text = f"{title}: a row of {side + 1} in a matrix of {side} columns; its '0 0' is read as '0.0' with the point lost"
    report.warning(line.number, f"{text}: check it")
    return replace(line, text=re.sub(r"(?<!\S)0 0(?!\S)", "0.0", line.text))
