"""Start of a command line: Ctrl-C ends it with one line, also while libraries are imported.

An exception within an import would end in a traceback, or be lost where a library catches it. This module imports
next to nothing: until it has run, Ctrl-C is answered by the interpreter.
"""

import os
import signal
import sys
from importlib import import_module

STOPPED = 130
"""The exit code after Ctrl-C: 128 and the number of SIGINT, as shells have it."""


def start(group: str, prog_name: str | None = None) -> None:
    """Import the module of a group of commands, and run its ``main``."""
    end_at_once()
    import_module(group).main(prog_name=prog_name)


def end_at_once() -> None:
    """Let Ctrl-C end the process as it is, unless somebody else has taken the signal: nothing is open yet."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_again() -> None:
    """Let Ctrl-C be a KeyboardInterrupt again, for what has to be closed in good order."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def leave() -> None:
    """End the process as it is, with `STOPPED`; a hidden cursor is shown again."""
    if sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b"\x1b[?25h\n")
    os._exit(STOPPED)


def _end(*_of: object) -> None:
    try:
        os.write(2, b"stopped\n")
    finally:  # nobody may read it
        os._exit(STOPPED)
