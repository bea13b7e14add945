"""Reads CANDY ``.tem`` files in all their dialects: linear, non-linear, delayed, of several layers, and scripts.

Grammar, in short (keywords in any case, the colon optional; ``%`` starts a comment, ``%Key: text`` is a header)::

    file     = {section}                         section  = ["LABEL" n] ["TEMPLATE" n] ["NEW"] body ["LOOP" n k]
    body     = ["NRLAYERS" n] {"LAYER" n words | "NEIGHBORHOOD" r | "CURRENT" z | "DELAY" t | block | function}
    block    = ("FEEDBACK" | "CONTROL" | "NONLIN_..." | "DELAYED_...") ["FROM" n] rows
    function = letter (0 | 1) n {x y}

Nothing is guessed silently: what is not plain is a diagnostic with its line. Source: the files themselves.
"""

import re
from typing import cast

from cnnsim.formats.candy.blocks import Cursor, is_function, read_argument, read_function, read_matrix
from cnnsim.formats.candy.content import Block, Operation, Section, TemFile
from cnnsim.formats.candy.layers import LayerBuilder, SectionBuilder
from cnnsim.formats.candy.lines import Line, decode, scan
from cnnsim.formats.numbers import number, whole
from cnnsim.support import Diagnostics, InputError

_LAYER = re.compile(r"(\d{1,6})(?!\d)(.*)", re.S | re.ASCII)  # free words may follow: LAYER 1 - photoreceptor
_FROM = re.compile(r"FROM\s*:?\s*(?:LAYER\s*)?(\S+?)\s*:?(?:\s+(.*))?", re.I | re.S)


def read_tem(data: bytes, report: Diagnostics) -> TemFile:
    """Read a file. The value holds what could be read; look at ``report.failed`` before trusting it."""
    return parse_tem(decode(data, report), report)


def parse_tem(text: str, report: Diagnostics) -> TemFile:
    """Read the text of a file."""
    lines, headers, comments = scan(text, report)
    cursor = Cursor(lines, report)
    sections: list[Section] = []
    loop: tuple[int, int] | None = None
    section = SectionBuilder(report)
    while line := cursor.peek():
        if line.keyword in ("LABEL", "TEMPLATE", "NEW"):
            cursor.take()
            if section.has_content:
                sections.append(section.finish())
                section = SectionBuilder(report)
            section.name(line)
        elif line.keyword == "LOOP":
            loop = _loop(cursor.take(), report, loop)
        elif is_function(line):
            if function := read_function(cursor):
                section.layer.add_function(function)
        elif line.keyword:
            _statement(cursor, section)
        else:
            cursor.take()
            report.error(line.number, f"{line.text[:40]!r} is no keyword, and no matrix is open here")
    if section.has_content or not sections:
        sections.append(section.finish())
    if not any(layer.blocks or layer.current is not None for part in sections for layer in part.layers):
        report.error(None, "no FEEDBACK, no CONTROL, no CURRENT: this is no template file")
    if loop is not None and str(loop[0]) not in {part.label for part in sections}:
        report.warning(None, f"LOOP goes back to a LABEL {loop[0]}, which is missing")
    return TemFile(tuple(sections), tuple(headers), tuple(comments), loop)


def _statement(cursor: Cursor, section: SectionBuilder) -> None:
    line, report = cursor.take(), cursor.report
    if line.keyword == "NRLAYERS":
        section.announce(line, _count(line, report))
    elif line.keyword == "LAYER":
        match = _LAYER.fullmatch(line.rest)
        if match is None:
            report.error(line.number, f"LAYER {line.rest[:40]!r}; a whole number wanted")
        section.open_layer(int(match[1]) if match else 0, match[2].strip(" \t-:,.") if match else "", line.number)
    elif line.keyword == "NEIGHBORHOOD":
        section.radius = _count(line, report)
    elif line.keyword == "CURRENT":
        section.layer.set_current(_value(line, report), line.number)
    elif line.keyword == "DELAY":
        section.layer.set_delay(_value(line, report), line.number)
    else:
        _block(cursor, line, section.layer, section.radius)


def _block(cursor: Cursor, line: Line, layer: LayerBuilder, radius: int | None) -> None:
    source, first = None, line.rest
    if match := _FROM.fullmatch(line.rest):
        source, first = whole(match[1]), match[2] or ""
        if source is None:
            cursor.report.error(line.number, f"{line.keyword} FROM {match[1][:40]!r}; the number of a layer wanted")
    _functions(cursor, layer)
    argument, factor = "", ""
    if line.keyword == "NONLIN_D":
        argument, factor = read_argument(cursor)
        _functions(cursor, layer, 5)
    rows = read_matrix(cursor, line, first)
    if not rows:
        return
    if radius is None:
        cursor.report.note(line.number, f"no NEIGHBORHOOD before {line.keyword}")
    elif radius != len(rows) // 2:
        side = len(rows)
        cursor.report.warning(
            line.number, f"{line.keyword} is {side} x {side} under NEIGHBORHOOD {radius}; the matrix counts"
        )
    operation = cast(Operation, line.keyword.lower())
    layer.add_block(Block(operation, rows, source, radius, argument, factor, None, line.number))


def _functions(cursor: Cursor, layer: LayerBuilder, words_at_least: int = 3) -> None:
    """Read the function lines that stand between a heading and its matrix."""
    while (ahead := cursor.peek()) and is_function(ahead, words_at_least):
        if function := read_function(cursor):
            layer.add_function(function)


def _value(line: Line, report: Diagnostics) -> float | None:
    word, *more = line.rest.split() or [""]
    if more:
        report.warning(line.number, f"{line.keyword}: what follows the number is not used: {' '.join(more)[:40]!r}")
    if ":" not in line.text:
        report.note(line.number, f"{line.keyword} without colon")
    try:
        return number(word)
    except InputError as error:
        report.error(line.number, f"{line.keyword}: {error}")
        return None


def _count(line: Line, report: Diagnostics) -> int | None:
    word, *more = line.rest.split() or [""]
    if more:
        report.warning(line.number, f"{line.keyword}: what follows the number is not used: {' '.join(more)[:40]!r}")
    count = whole(word)
    if count is None:
        report.error(line.number, f"{line.keyword}: {word[:40]!r}; a whole number wanted")
    return count


def _loop(line: Line, report: Diagnostics, before: tuple[int, int] | None) -> tuple[int, int] | None:
    counts = [whole(word) for word in line.rest.split()]
    if before is not None or len(counts) != 2 or counts[0] is None or counts[1] is None:
        report.error(line.number, f"LOOP {line.rest[:40]!r}; one loop with two whole numbers, label and times, wanted")
        return before
    return counts[0], counts[1]
