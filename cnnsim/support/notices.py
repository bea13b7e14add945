"""Notices to users that are no errors: a Python warning, or one line on stderr of a command."""

import sys
import warnings
from collections.abc import Callable


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
