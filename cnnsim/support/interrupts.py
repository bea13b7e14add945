"""Ctrl-C while a library compiles: handled between two passes of the compiler; a second one ends a command at once.

Numba's compiler calls back from LLVM. A KeyboardInterrupt that Python raises there is lost, or leaves a function half
compiled. So the signal is recorded while numba compiles, and raised when the compiler is back in Python.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cnnsim.start import leave


class Stopping:
    """The interrupt that is pending, if any."""

    command_line = False
    """Set by command lines: a second Ctrl-C ends the process; an interactive Python continues."""
    foreign = 0
    """Calls into libraries whose own threads crash the process if it ends before them."""
    _depth = 0
    _pending = False

    @classmethod
    def compiling(cls, depth: int) -> None:
        """Record that the main thread enters (1) or leaves (-1) the compiler; calls nest."""
        if threading.current_thread() is not threading.main_thread():
            return
        cls._depth += depth
        if depth > 0 and cls._depth == 1 and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, cls.record)
        elif cls._depth == 0:
            if signal.getsignal(signal.SIGINT) == cls.record:
                signal.signal(signal.SIGINT, signal.default_int_handler)
            cls.check()

    @classmethod
    def check(cls) -> None:
        """Raise the pending KeyboardInterrupt; called where nothing is half done."""
        if cls._pending and threading.current_thread() is threading.main_thread():
            cls._pending = False
            raise KeyboardInterrupt

    @classmethod
    def is_compiling(cls) -> bool:
        """Return whether the main thread is in the compiler."""
        return cls._depth > 0

    @classmethod
    def record(cls, *_of: Any) -> None:
        """Record an interrupt; a second one ends a command at once."""
        if cls._pending and cls.command_line:
            leave()
        cls._pending = True


@contextmanager
def foreign_call() -> Iterator[None]:
    """Count a call, see `Stopping.foreign`."""
    Stopping.foreign += 1
    try:
        yield
    finally:
        Stopping.foreign -= 1


@contextmanager
def held_back() -> Iterator[None]:
    """Postpone Ctrl-C to the end of a block that must not be interrupted."""
    Stopping.compiling(1)
    try:
        yield
    finally:
        Stopping.compiling(-1)


def listen_to_numba() -> None:
    """Register the interrupt handling with numba's compiler."""
    from numba.core import event  # slow to import, and imported already

    class Lock(event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        def on_start(self, _event: Any) -> None:
            Stopping.compiling(1)

        def on_end(self, _event: Any) -> None:
            Stopping.compiling(-1)

    class Pass(event.Listener):  # type: ignore[misc]  # the same
        def on_start(self, _event: Any) -> None:
            Stopping.check()

        def on_end(self, _event: Any) -> None:
            pass

    event.register("numba:compiler_lock", Lock())
    event.register("numba:run_pass", Pass())
