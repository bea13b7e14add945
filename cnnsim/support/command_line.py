"""Common parts of both command lines: errors as one line and exit code 2, Ctrl-C, progress bars, JSON, examples."""

import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from errno import EPIPE
from pathlib import Path
from typing import Any, TypeVar

import click

from cnnsim.start import Stop, leave, raise_again
from cnnsim.support.command_files import CommandFiles, command_files
from cnnsim.support.errors import InputError
from cnnsim.support.interrupts import Stopping
from cnnsim.support.notices import CompileNotice, Notices
from cnnsim.support.progress import terminal_bar, watched_by
from cnnsim.support.terminal import as_markup, console, drop_unwritten, echo, json_line, printable, take_any_text

Item = TypeVar("Item")
LONGEST = 3000
"""Characters of a message, which may list twenty errors of a file."""

_JSON = "cnnsim.support.command_line.json"


class _Mistake(click.ClickException):
    exit_code = 2

    def __init__(self, message: str) -> None:
        text = printable(" ".join(message.split()))
        if len(text) > LONGEST:  # a file's value may be quoted in it
            text = f"{text[: LONGEST // 2]} ... {text[-LONGEST // 2 :]}"
        super().__init__(text)


@contextmanager
def _printable_mistakes() -> Iterator[None]:
    """Replace control characters in click's messages, which quote arguments."""
    try:
        yield
    except click.ClickException as error:
        vars(error)["message"] = printable(error.message)
        raise


class CommandGroup(click.Group):
    """A click group that reports wrong input and errors of the system as one line, without a traceback."""

    def main(self, *args: Any, **options: Any) -> Any:
        """Run a command line."""
        take_any_text()
        try:
            return super().main(*args, **options)
        except OSError as error:  # the help of the group itself is printed before any command is called
            with suppress(OSError):
                echo(f"Error: {_refused(error)}", err=True)
            drop_unwritten()
            sys.exit(_Mistake.exit_code)

    def make_context(self, *args: Any, **options: Any) -> click.Context:
        """Read the group's own options."""
        with _printable_mistakes():
            return super().make_context(*args, **options)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Find the command.

        Raises:
            InputError: an argument is empty, which would name the present folder, or "-".
        """
        ctx.meta[_JSON] = "--json" in args
        CompileNotice.wanted = sys.stderr.isatty() or not ctx.meta[_JSON]
        if "" in args:
            where = f"argument {args.index('')} of {args[0] or 'the command'}"
            raise InputError(f"{where} is empty; a value wanted (an unset variable of the shell?)")
        if "-" in args:
            raise InputError(
                f"argument {args.index('-')} of {args[0]} is '-'; a file wanted, no standard input or output"
            )
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; with --json an error is printed as JSON on stdout as well."""
        try:
            return self._invoked(ctx)
        except click.ClickException as error:
            if ctx.meta.pop(_JSON, False):  # once, for groups in a group
                with suppress(OSError):  # stdout may have failed
                    echo(json_line({"error": " ".join(error.format_message().split())}))
            drop_unwritten()
            raise

    def _invoked(self, ctx: click.Context) -> Any:
        before, Notices.tell = Notices.tell, _tell
        Stopping.command_line = True
        try:
            raise_again()
            with command_files(_tell_replaced), _printable_mistakes(), watched_by(terminal_bar()):
                return super().invoke(ctx)
        except KeyboardInterrupt:
            echo("stopped", err=True)
            if Stopping.foreign:
                sys.stdout.flush()
                _release_semaphores()
                leave()
            ctx.exit(Stop.code)
        except InputError as error:
            raise _Mistake(str(error)) from error
        except OSError as error:
            if error.errno == EPIPE:  # the reader of our output is gone: click exits without a message
                raise
            raise _Mistake(_refused(error)) from error
        except (MemoryError, OverflowError, RecursionError) as error:
            raise _Mistake(f"too large: {str(error) or type(error).__name__}") from error
        finally:
            Notices.tell = before


def _release_semaphores() -> None:
    """Release the semaphores of worker processes; else Python's resource tracker warns of them."""
    if (multiprocessing := sys.modules.get("multiprocessing.util")) is not None:
        multiprocessing._run_finalizers()


def _refused(error: OSError) -> str:
    return f"{error.filename or 'the system'}: {error.strerror or error}"


def _tell(notice: str) -> None:
    echo(notice, err=True)


def _tell_replaced(path: Path) -> None:
    echo(f"replaced {path}", err=True)


def _allow_replacing(_context: click.Context, _option: click.Parameter, given: bool) -> bool:
    if CommandFiles.current is not None:
        CommandFiles.current.replace = given
    return given


replace_option = click.option(
    "--replace", is_flag=True, expose_value=False, callback=_allow_replacing, help="Overwrite existing files."
)


def watched(items: Iterable[Item], what: str, total: float | None = None) -> Iterable[Item]:
    """Yield items, with a progress bar if stderr is a terminal."""
    return _tracked(items, what, total) if sys.stderr.isatty() else items


def _tracked(items: Iterable[Item], what: str, total: float | None) -> Iterator[Item]:
    from rich.progress import track  # slow to import, and only needed on a terminal

    with watched_by(None):  # one bar on one terminal
        yield from track(items, as_markup(what), total=total, console=console(err=True), transient=True)


@contextmanager
def progress(what: str) -> Iterator[Any]:
    """Yield a function that iterates over a list, with a progress bar if stderr is a terminal."""
    from rich.progress import Progress  # slow to import, and only needed on a terminal

    shown = sys.stderr.isatty()
    with watched_by(None), Progress(console=console(err=True), transient=True, disable=not shown) as bar:

        def track(levels: Iterable[Any]) -> Iterator[Any]:
            yield from bar.track(list(levels), description=as_markup(what))

        yield track


def print_json(data: Any) -> None:
    """Print data as JSON; NaN and infinities become null."""
    echo(json.dumps(_plain(data), indent=1, allow_nan=False))


def _plain(data: Any) -> Any:
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and not abs(data) < float("inf"):
        return None
    return data


def examples(*lines: str) -> str:
    """Return a click epilog with example calls."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
