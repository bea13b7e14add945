"""Cuts the bytes of a ``.tem`` file into lines, header comments and keywords."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from cnnsim.formats.candy.content import Header
from cnnsim.support import Diagnostics

KEYWORDS = (
    "NEIGHBORHOOD", "NEIGHBOURHOOD", "FEEDBACK", "CONTROL", "CURRENT", "NONLIN_FEEDBACK", "NONLIN_CONTROL", "NONLIN_D",
    "DELAY", "DELAYED_FEEDBACK", "DELAYED_CONTROL", "NRLAYERS", "LAYER", "LABEL", "TEMPLATE", "NEW", "LOOP", "COMMENT",
)  # fmt: skip
_KEYWORD = re.compile(rf"({'|'.join(sorted(KEYWORDS, key=len, reverse=True))})(?![A-Za-z_])\s*:?\s*(.*)", re.I | re.S)
_HEADER = re.compile(r"%\s*([A-Za-z]\w*)\s*:\s*(.*)", re.S)
_LINE_END = re.compile(r"\r*\n|\r+")


@dataclass(frozen=True)
class Line:
    """A line with content: its number, its text without comment, its keyword and the text after that."""

    number: int
    text: str
    keyword: str = ""
    rest: str = ""

    @property
    def words(self) -> list[str]:
        """The text, cut at blanks and tabs."""
        return self.text.split()


def decode(data: bytes, report: Diagnostics) -> str:
    """Return the text: UTF-8 if it is that, else the Windows code page 1252, else Latin-1."""
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if encoding == "cp1252":
            report.note(None, "read as Windows code page 1252")
        return text
    report.note(None, "read as Latin-1")
    return data.decode("latin-1")


def split(text: str, report: Diagnostics) -> Iterator[tuple[int, str]]:
    """Yield the numbered lines; DOS, Unix and doubled carriage returns all end one line."""
    if "\x1a" in text:
        if text.split("\x1a", 1)[1].strip("\x1a \t\r\n"):
            line = len(_LINE_END.split(text.split("\x1a", 1)[0]))
            report.warning(line, "there is text after the DOS end-of-file sign 0x1A; it is read as well")
        else:
            report.note(None, "stray DOS end-of-file sign 0x1A at the end")
        text = text.replace("\x1a", " ")
    yield from enumerate(_LINE_END.split(text), start=1)


def scan(text: str, report: Diagnostics) -> tuple[list[Line], list[Header], list[str]]:
    """Return the lines that say something, the header comments, and all other comments."""
    lines: list[Line] = []
    headers: list[Header] = []
    comments: list[str] = []
    for number, raw in split(text, report):
        body, sign, comment = raw.partition("%")
        if sign and not body.strip() and (match := _HEADER.fullmatch(raw.strip())):
            headers.append(Header(match[1], match[2].strip(), number))
        elif comment.strip("% \t"):
            comments.append(comment.strip("% \t"))
        if not body.strip():
            continue
        keyword = _KEYWORD.fullmatch(body.strip())
        if keyword and keyword[1].upper() == "COMMENT":
            comments.append(keyword[2].strip())
        elif keyword:
            word = keyword[1].upper().replace("NEIGHBOURHOOD", "NEIGHBORHOOD")
            lines.append(Line(number, body.strip(), word, keyword[2].strip()))
        else:
            lines.append(Line(number, body.strip()))
    _look_for_doubles(headers, report)
    return lines, headers, comments


def _look_for_doubles(headers: list[Header], report: Diagnostics) -> None:
    seen: set[str] = set()
    for header in headers:
        if header.key.lower() in seen:
            report.warning(header.line, f"a second %{header.key}; the first one counts")
        seen.add(header.key.lower())
