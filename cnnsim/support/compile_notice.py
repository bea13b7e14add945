"""Compile notice: tells a terminal, once, that loops are being compiled; loops from the disk cache say nothing."""

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


class Terminal:
    """Where to say it: ``wanted`` is set by command lines whose stderr is a terminal."""

    wanted = False


def announce(where: str) -> None:
    """Say it on stderr when loops that are kept in ``where`` are compiled, if a command line has asked for it."""
    if not Terminal.wanted:
        return
    from numba.core import event

    def say() -> None:
        from cnnsim.support.echo import console  # click and rich are slow to import

        console(err=True).print(f"compiling, once; kept in {where}", style="dim", soft_wrap=True, highlight=False)

    class Listener(Notice, event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        pass

    event.register("numba:run_pass", Listener(say))
