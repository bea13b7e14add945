"""Output on a terminal, without control characters: lines, wrapped tables, JSON and the console of rich."""

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
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"  # direction marks and line separators
    "\ud800-\udfff]"  # bytes of a file name that are not UTF-8
)


NARROWEST = 40
"""Columns to which lines are wrapped at least, also on a narrower terminal."""


def printable(text: object) -> str:
    """Return a text with every control character replaced by a question mark; tabs and line feeds stay."""
    return _CONTROL.sub("?", str(text))


def json_line(data: Any) -> str:
    """Return data as JSON on one line with all control characters escaped."""
    line = json.dumps(data, ensure_ascii=False, allow_nan=False)
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", line)


def as_markup(text: object) -> str:
    """Return the rich markup that shows a text literally."""
    from rich.markup import escape  # slow to import, and only needed on a terminal

    return escape(printable(text))


def take_any_text() -> None:
    """Make stdout and stderr accept any text: a closed stream discards it, characters it cannot encode become ?."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - open until the process ends
        elif isinstance(stream, TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            stream.reconfigure(errors="replace")


def drop_unwritten() -> None:
    """Discard the buffer of stdout if it cannot be written; else it would fail again when the process ends."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def echo(text: object = "", *, err: bool = False, over: bool = False) -> None:
    """Print a text on stdout or, with ``err``, on stderr; ``over`` overwrites the present line."""
    click.echo(f"\r{printable(text)} " if over else printable(text), err=err, nl=not over)


def tell_process(text: object) -> None:
    """Print a dim line on the original stderr of the process; do nothing if that is closed."""
    with suppress(OSError):
        click.echo(click.style(printable(text), dim=True), file=sys.__stderr__ or sys.stderr)


def console(width: int = 150, *, err: bool = False) -> "Console":
    """Return a rich console as wide as the terminal, or ``width`` columns if the output is no terminal.

    Texts are shown literally, without control characters; `rich.text.Text` gives them a style.
    """
    from rich.console import Console  # slow to import, and only needed on a terminal

    class TextConsole(Console):
        def render_str(self, text: str, **options: Any) -> Any:
            return super().render_str(printable(text), **{**options, "markup": False, "emoji": False})

    terminal = TextConsole(stderr=err)
    return terminal if terminal.is_terminal else TextConsole(stderr=err, width=width)


def hanging(head: str, text: str, indent: int) -> str:
    """Return ``head`` and a text to its right, wrapped to the terminal's width with a hanging indent.

    The head has a line of its own if it is longer than ``indent`` or if ``indent`` is more than half of the width.
    Paths and long words are not broken.
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
    """Print a line, wrapped to the width of the terminal, with its further lines indented."""
    lines = wrap(line, _width(), subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)
    echo("\n".join(lines), err=err)


def say_table(rows: Iterable[tuple[str, str]], most: int = 32) -> None:
    """Print names and texts in two columns; the second is wrapped to the width of the terminal."""
    rows = list(rows)
    indent = max((len(name) for name, _ in rows if len(name) <= most), default=0) + 2
    for name, text in rows:
        echo(hanging(name if len(name) > indent else name.ljust(indent), text, indent))
