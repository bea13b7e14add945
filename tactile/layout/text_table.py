"""Tables in text files: any separator, header, preamble and decimal sign, read with pyarrow."""

import codecs
import io
import re
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.errors import cut
from cnnsim.support.extras import need
from cnnsim.support.limits import TABLE, check_file, one_line
from tactile.layout.array_tables import arrow_array
from tactile.layout.table import EXTRA, Table

SEPARATORS = {"\t": r"\t", ";": ";", ",": ",", "|": r"\|", " ": r"[ \t]+"}
"""Separator -> its regular expression, in the order of preference."""
SAMPLE = 400
"""Number of lines from which separator, header and decimal sign are found."""
COMMENT = ("#", "%", "//")
"""Beginnings of lines that are no rows."""
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|nan|[+-]?inf(inity)?", re.IGNORECASE)
EMPTY = ("", "nan", "NaN", "NAN", "inf", "-inf", "Inf", "-Inf", "null", "NULL", "NA", "N/A", "None", "-", "ovf", "OVF")
"""Cells without a reading."""


class TextForm(NamedTuple):
    """Form of a text table: ``separator``, decimal sign, ``names`` of the columns, and ``first`` line with a row."""

    separator: str
    decimal: str
    names: list[str]
    first: int


def read_text(path: Path, layout: Any = None) -> Table:
    """Return the columns of a text file; without a header they are named by their number, ``0``, ``1``, ...

    A cell that is no number is no reading, in a column in which most cells are numbers.

    Raises:
        InputError: no text file, or no rows of numbers in it.
    """
    csv = need("pyarrow.csv", "a text table of another program", EXTRA)
    with one_line(path, "a text table"):
        check_file(path, "text table", TABLE)
        lines = _decoded(path.read_bytes()).splitlines()
    form = text_form(path, lines, layout)
    rows = [line for line in lines[form.first :] if line.strip() and not line.lstrip().startswith(COMMENT)]
    separator = "\t" if form.separator == " " else form.separator
    if form.separator == " ":
        rows = ["\t".join(line.split()) for line in rows]
    elif form.separator != "\t":
        rows = [line.rstrip() for line in rows]
    width = len(form.names)
    rows = [line.removesuffix(separator) if line.count(separator) == width else line for line in rows]
    unfit: list[Any] = []

    def skip(row: Any) -> str:
        unfit.append(row)
        return "skip"

    body = io.BytesIO("\n".join([*rows, ""]).encode())
    with one_line(path, "a text table"):
        read = csv.read_csv(
            body,
            csv.ReadOptions(column_names=form.names, use_threads=False),
            csv.ParseOptions(delimiter=separator, invalid_row_handler=skip, ignore_empty_lines=True),
            csv.ConvertOptions(null_values=EMPTY, strings_can_be_null=True, decimal_point=form.decimal),
        )
    columns = {name: _column(read.column(i), form.decimal) for i, name in enumerate(form.names)}
    notes = []
    if unfit:
        first = cut(str(unfit[0].text))
        notes.append(
            f"{len(unfit)} of {len(rows)} lines have not {len(form.names)} cells and are skipped, the first has"
            f" {unfit[0].actual_columns}: {first!r}"
        )
    return Table(path, {name: one for name, one in columns.items() if one is not None}, tuple(notes))


def text_form(path: Path, lines: list[str], layout: Any = None) -> TextForm:
    """Return the form of a text table: what the ``layout`` says, and what its first lines show.

    Raises:
        InputError: no two lines of numbers.
    """
    start = layout.skip_lines if layout is not None else 0
    chosen = layout.separator if layout is not None else None
    sample = [(n, line) for n, line in enumerate(lines[start : start + SAMPLE], start) if line.strip()]
    plain = [(n, line.strip()) for n, line in sample if not line.lstrip().startswith(COMMENT)]
    best: tuple[float, str, int, int] | None = None
    for separator in [chosen] if chosen else SEPARATORS:
        counts = Counter(len(cells) for _, line in plain if _numeric(cells := _cells(line, separator)))
        if counts:
            width, hits = max(counts.items(), key=lambda item: (item[1], item[0]))
            score = hits * (1 if width > 1 else 0.5)
            if best is None or score > best[0] or (score == best[0] and width > best[2]):
                first = next(n for n, line in plain if len(_cells(line, separator)) == width and
                             _numeric(_cells(line, separator)))  # fmt: skip
                best = score, separator, width, first
    if best is None:
        shown = cut(plain[0][1]) if plain else "nothing"
        raise InputError(f"{path}: no lines of numbers in it, which are wanted; it begins with {shown!r}")
    _, separator, width, first = best
    body = [_cells(line, separator) for n, line in plain if n >= first]
    width -= all(row[-1] == "" for row in body if len(row) == width) and width > 1
    decimal = layout.decimal if layout is not None and layout.decimal else None
    if decimal is None:
        cells = [cell for row in body for cell in row]
        decimal = "," if separator != "," and any("," in cell for cell in cells) else "."
    return TextForm(separator, decimal, _names(lines, start, first, separator, width), first)


def _names(lines: list[str], start: int, first: int, separator: str, width: int) -> list[str]:
    """Return the column names: of the first line of as many cells right above the rows, else numbers."""
    found: list[str] = []
    for line in reversed(lines[start:first]):
        for text in (line.strip(), line.strip().lstrip("#%/ \t")):
            cells = [cell.strip(" \"'") for cell in _cells(text, separator)]
            cells = cells[:-1] if len(cells) == width + 1 and not cells[-1] else cells
            if len(cells) == width and not _numeric(cells):
                found = cells
                break
        else:
            if line.strip():
                break
    names: list[str] = []
    for number in range(width):
        name = (found[number] if found else "") or str(number)
        taken = sum(one == name or one.rpartition(".")[0] == name for one in names)
        names.append(f"{name}.{taken}" if taken else name)
    return names


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in re.split(SEPARATORS.get(separator, re.escape(separator)), line)]


def _numeric(cells: list[str]) -> bool:
    """Return whether a line is a row: at least half of its filled cells are numbers."""
    filled = [cell.strip("\"'") for cell in cells if cell]
    return bool(filled) and 2 * sum(NUMBER.fullmatch(cell) is not None for cell in filled) >= len(filled)


def _column(column: Any, decimal: str) -> Any:
    """Return a column of pyarrow as numbers, if most of its filled cells are numbers, else as texts."""
    array = arrow_array(column)
    if array is None:  # no cell is filled
        return np.full(len(column), np.nan)
    if array.dtype.kind != "U":
        return array
    words, place = np.unique(array, return_inverse=True)
    numbers = np.array([_number(word, decimal) for word in words.tolist()])[place]
    filled = array != ""
    return numbers if 2 * np.isfinite(numbers[filled]).sum() > filled.sum() else array


def _number(word: str, decimal: str) -> float:
    try:
        number = float(word.strip(" \"'[]()").replace(decimal, "."))
    except ValueError:
        return float("nan")
    return number if abs(number) < float("inf") else float("nan")


def _decoded(data: bytes) -> str:
    for mark, coding in (
        (codecs.BOM_UTF8, "utf-8-sig"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    ):
        if data.startswith(mark):
            return data.decode(coding)
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")
