"""Notices to users that are no errors: a Python warning, or one line on stderr of a command."""

import sys
import warnings
from collections.abc import Callable
from typing import Any


class Notices:
    """Who is told what the machine lacks, or what is odd in a file: stderr where a command sets ``tell``.

    Else a Python warning.
    """

    tell: Callable[[str], None] | None = None
    _told: set[str] = set()  # noqa: RUF012 - of the process, as all of this

    @classmethod
    def once(cls, text: str) -> None:
        """Tell something, once a process."""
        if text in cls._told:
            return
        cls._told.add(text)
        cls.say(text, RuntimeWarning)

    @classmethod
    def say(cls, text: str, kind: type[Warning] = UserWarning) -> None:
        """Tell something; a Python warning points to the line of the user that called."""
        if cls.tell is None:
            warnings.warn(text, kind, stacklevel=users_level())
        else:
            cls.tell(text)


def users_level() -> int:
    """Return the ``stacklevel`` with which a warning of who calls this points to a line of the user.

    Doors have decorators, and one door calls another: no number would be right for all.
    """
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in ("cnnsim", "tactile"):
        level, frame = level + 1, frame.f_back
    return level


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
        from cnnsim.support.terminal import tell_process  # slow to import, and only needed where something compiles

        tell_process(f"compiling loops, once, for a minute or so; kept in {where}")

    class Listener(Notice, event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        pass

    event.register("numba:run_pass", Listener(say))
