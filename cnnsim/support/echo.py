"""Texts of files and command lines printed on a terminal: nothing in them moves its cursor, colours it or is markup."""

import json
import re
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # C0 without tab and line feed, delete, C1
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"  # what turns the direction of the text after it, line separators
    "\ud800-\udfff]"  # bytes of a file's name that are no UTF-8
)


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


def echo(text: object = "", *, err: bool = False, over: bool = False) -> None:
    """Print a text on stdout, or stderr; ``over`` replaces the line that the cursor is on, and stays on it."""
    click.echo(f"\r{printable(text)} " if over else printable(text), err=err, nl=not over)


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
