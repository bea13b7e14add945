"""Plumbing of both command lines: errors as one line and exit code 2, progress bars, JSON, example calls."""

import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from errno import EPIPE
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from cnnsim.support.compile_notice import Terminal
from cnnsim.support.errors import InputError
from cnnsim.support.files import Replaced

if TYPE_CHECKING:
    from rich.console import Console

Item = TypeVar("Item")


class _Mistake(click.ClickException):
    exit_code = 2


class CommandGroup(click.Group):
    """A click group that turns wrong input, and what the system refuses, into one line instead of a traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        Terminal.wanted = sys.stderr.isatty()
        Replaced.tell = _tell_replaced
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise _Mistake(" ".join(str(error).split())) from error
        except OSError as error:
            if error.errno == EPIPE:  # whoever read our output has gone: click leaves in silence
                raise
            raise _Mistake(f"{error.filename or 'the system'}: {error.strerror or error}") from error
        except (MemoryError, OverflowError, RecursionError) as error:
            raise _Mistake(f"too large: {' '.join(str(error).split()) or type(error).__name__}") from error


def _tell_replaced(path: Path) -> None:
    click.echo(f"replaced {path}", err=True)


def console(width: int = 150) -> "Console":
    """The console of tables: as wide as the terminal, or ``width`` where the output is no terminal."""
    from rich.console import Console  # slow to import, and only needed on a terminal

    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=width)


def watched(items: Iterable[Item], what: str, total: float | None = None) -> Iterable[Item]:
    """Hand items on, with a bar on stderr that shows how far it is; only on a terminal."""
    if not sys.stderr.isatty():
        return items
    from rich.console import Console  # slow to import, and only needed on a terminal
    from rich.progress import track  # the same

    return track(items, what, total=total, console=Console(stderr=True), transient=True)


@contextmanager
def progress(what: str) -> Iterator[Any]:
    """Give a function that goes through a list and shows how far it is, on stderr and only on a terminal."""
    from rich.console import Console  # slow to import, and only needed on a terminal
    from rich.progress import Progress  # the same

    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:

        def track(levels: Iterable[Any]) -> Iterator[Any]:
            yield from bar.track(list(levels), description=what)

        yield track


def print_json(data: Any) -> None:
    """Print plain data as JSON that any parser reads: NaN and infinities become null."""
    click.echo(json.dumps(_plain(data), indent=1, allow_nan=False))


def _plain(data: Any) -> Any:
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and not abs(data) < float("inf"):
        return None
    return data


def examples(*lines: str) -> str:
    """Return an epilog that shows example calls as they are typed."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
