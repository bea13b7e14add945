"""Ctrl-C while libraries compile: heard between two passes of a compiler, and by the second at once.

numba's compiler calls back from LLVM. A KeyboardInterrupt that Python raises in there is lost, or leaves half a
function behind; so while it compiles the signal is noted, and raised where the compiler is in Python's hands again.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cnnsim.start import leave


class Stopping:
    """What is known of a stop that somebody wants."""

    command_line = False
    """Set by command lines, which a second Ctrl-C ends; a session in Python goes on."""
    foreign = 0
    """Calls into libraries that go on in threads of their own and end the process badly if it ends before them."""
    _depth = 0
    _heard = False

    @classmethod
    def compiling(cls, depth: int) -> None:
        """Take that the main thread enters (1) or leaves (-1) the compiler, which it may do within itself."""
        if threading.current_thread() is not threading.main_thread():
            return
        cls._depth += depth
        if depth > 0 and cls._depth == 1 and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, cls._hear)
        elif cls._depth == 0 and signal.getsignal(signal.SIGINT) == cls._hear:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            cls.check()

    @classmethod
    def check(cls) -> None:
        """Raise what was heard; called where nothing is half done."""
        if cls._heard and threading.current_thread() is threading.main_thread():
            cls._heard = False
            raise KeyboardInterrupt

    @classmethod
    def _hear(cls, *_of: Any) -> None:
        if cls._heard and cls.command_line:
            leave()
        cls._heard = True


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
    """Hold Ctrl-C back in a block that it must not cut in two, and raise it at the end."""
    Stopping.compiling(1)
    try:
        yield
    finally:
        Stopping.compiling(-1)


def listen_to_numba() -> None:
    """Have numba tell when it compiles."""
    from numba.core import event  # slow to import, and there by now

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
