"""Compile notice: tells stderr, once, that loops are being compiled; loops from the disk cache say nothing."""

from collections.abc import Callable
from typing import Any


class Notice:
    """Listens to numba's compiler passes and calls ``say`` at the first: there is none for loops that are only loaded.

    It is the event that tells and not the time: on a busy machine loading takes seconds, too.
    """

    def __init__(self, say: Callable[[], None]) -> None:
        self._say: Callable[[], None] | None = say

    def on_start(self, _event: Any = None) -> None:
        """A pass starts."""
        say, self._say = self._say, None
        if say is not None:
            say()

    def on_end(self, _event: Any = None) -> None:
        """It has done."""


class Told:
    """Whether to say it: ``wanted`` is set by command lines, but of JSON only on a terminal.

    Whoever reads JSON from a pipe may have both streams in one.
    """

    wanted = False


def announce(where: str) -> None:
    """Say it when loops that are kept in ``where`` are compiled, if a command line has asked for it."""
    if not Told.wanted:
        return
    from numba.core import event

    def say() -> None:
        from cnnsim.support.echo import tell_process  # slow to import, and only needed where something compiles

        tell_process(f"compiling loops, once, for a minute or so; kept in {where}")

    class Listener(Notice, event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        pass

    event.register("numba:run_pass", Listener(say))
