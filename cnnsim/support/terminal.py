"""Texts of files and command lines printed on a terminal: nothing in them moves its cursor, colours it or is markup."""

import json
import os
import re
import sys
from collections.abc import Iterable
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # C0 without tab and line feed, delete, C1
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"  # what turns the direction of the text after it, line separators
    "\ud800-\udfff]"  # bytes of a file's name that are no UTF-8
)


NARROWEST = 40
"""Columns to which lines are wrapped on any narrower terminal."""


def printable(text: object) -> str:
    """Return a text with a question mark in the place of every control character; tabs and line feeds stay."""
    return _CONTROL.sub("?", str(text))


def json_line(data: Any) -> str:
    """Return plain data as JSON on one line, letters as they are and all control characters escaped."""
    line = json.dumps(data, ensure_ascii=False, allow_nan=False)
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", line)


def as_markup(text: object) -> str:
    """Return the rich markup that shows a text as it is, for the few places of rich that take nothing else."""
    from rich.markup import escape  # slow to import, and only needed on a terminal

    return escape(printable(text))


def take_any_text() -> None:
    """Let stdout and stderr take any text: one that is closed leads nowhere, letters it cannot write become ?."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - open to the end
        elif isinstance(stream, TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            stream.reconfigure(errors="replace")


def drop_unwritten() -> None:
    """Lead stdout nowhere if it cannot write what it holds: it would fail once more where the process ends."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def echo(text: object = "", *, err: bool = False, over: bool = False) -> None:
    """Print a text on stdout, or stderr; ``over`` replaces the line that the cursor is on, and stays on it."""
    click.echo(f"\r{printable(text)} " if over else printable(text), err=err, nl=not over)


def tell_process(text: object) -> None:
    """Print a dim line on the stderr that the process began with, whatever stands in its place; it may have gone."""
    with suppress(OSError):
        click.echo(click.style(printable(text), dim=True), file=sys.__stderr__ or sys.stderr)


def console(width: int = 150, *, err: bool = False) -> "Console":
    """Return the console of tables and bars: as wide as the terminal, or ``width`` where the output is no terminal.

    Texts are shown as they are, without control characters; `rich.text.Text` gives them a style.
    """
    from rich.console import Console  # slow to import, and only needed on a terminal

    class TextConsole(Console):
        def render_str(self, text: str, **options: Any) -> Any:
            return super().render_str(printable(text), **{**options, "markup": False, "emoji": False})

    terminal = TextConsole(stderr=err)
    return terminal if terminal.is_terminal else TextConsole(stderr=err, width=width)


def hanging(head: str, text: str, indent: int) -> str:
    """Return a text beside ``head``, its further lines ``indent`` columns in, wrapped to the width of the terminal.

    A head that leaves no room for the text, or less than half of a narrow terminal, has a line of its own. Paths and
    long words are not broken.
    """
    narrow = bool(head) and indent > _width() // 2
    indent = 4 if narrow else indent
    first = head.ljust(indent)
    lead = [head.rstrip()] if narrow or len(first) > indent else []
    lines = wrap(text, _width(), initial_indent=" " * indent if lead else first, subsequent_indent=" " * indent,
                 break_long_words=False, break_on_hyphens=False)  # fmt: skip
    return "\n".join([*lead, *lines]) if lines else head.rstrip()


def _width() -> int:
    return max(NARROWEST, min(get_terminal_size().columns, 120))


def say(line: str, indent: int = 2, *, err: bool = False) -> None:
    """Print a line, wrapped to the width of the terminal, what follows ``indent`` columns in."""
    lines = wrap(line, _width(), subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)
    echo("\n".join(lines), err=err)


def say_table(rows: Iterable[tuple[str, str]], most: int = 32) -> None:
    """Print names and texts in two columns; the second is wrapped to the width of the terminal."""
    rows = list(rows)
    indent = max((len(name) for name, _ in rows if len(name) <= most), default=0) + 2
    for name, text in rows:
        echo(hanging(name if len(name) > indent else name.ljust(indent), text, indent))
