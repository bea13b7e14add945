"""Notices to users: a Python warning, or one line on stderr of a command; among them that loops are being compiled."""

import sys
import warnings
from collections.abc import Callable
from typing import Any


class Notices:
    """Where notices go: to ``tell``, which commands set to print on stderr, else to Python warnings."""

    tell: Callable[[str], None] | None = None
    _given: set[str] = set()  # noqa: RUF012 - of the process, as all of this

    @classmethod
    def once(cls, text: str) -> None:
        """Give a notice once in a process."""
        if text not in cls._given:
            cls._given.add(text)
            cls.say(text, RuntimeWarning)

    @classmethod
    def say(cls, text: str, kind: type[Warning] = UserWarning) -> None:
        """Give a notice; a Python warning points to the calling line of the user."""
        if cls.tell is None:
            warnings.warn(text, kind, stacklevel=users_level())
        else:
            cls.tell(text)


def users_level() -> int:
    """Return the ``stacklevel`` with which a warning of the caller points to the user's code, outside this package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in ("cnnsim", "tactile"):
        level, frame = level + 1, frame.f_back
    return level


class CompileNotice:
    """Whether commands report that loops are being compiled.

    It is ``wanted`` unless a command prints JSON to a pipe, whose reader may have both streams in one.
    """

    wanted = False


def announce(where: str) -> None:
    """Print a notice on stderr, once, when numba compiles a loop; ``where`` is the cache folder.

    Loading a loop from the cache runs no pass of numba's compiler.
    """
    if not CompileNotice.wanted:
        return
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        given = False

        def on_start(self, _event: Any) -> None:
            from cnnsim.support.terminal import tell_process  # slow to import, and only needed where something compiles

            if not self.given:
                self.given = True
                tell_process(f"compiling loops, once, for a minute or so; kept in {where}")

        def on_end(self, _event: Any) -> None:
            pass

    event.register("numba:run_pass", Listener())
