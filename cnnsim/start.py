"""Start of a command line: Ctrl-C ends it with one line, also while libraries are imported.

An exception within an import would end in a traceback, or be lost where a library catches it. This module imports few
modules, because until it has run, the interpreter handles Ctrl-C.
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
    """Let Ctrl-C end the process without cleanup, as nothing is open yet; another handler of SIGINT is kept."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_again() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, so that open files and devices are closed."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def leave() -> None:
    """End the process without cleanup, with `STOPPED`; a hidden cursor is shown again."""
    if sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b"\x1b[?25h\n")
    os._exit(STOPPED)


def _end(*_of: object) -> None:
    try:
        os.write(2, b"stopped\n")
    finally:  # stderr may be closed
        os._exit(STOPPED)
