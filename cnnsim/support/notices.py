"""Notices to users that are no errors: a Python warning, or one line on stderr of a command."""

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
        cls.say(text, 4, RuntimeWarning)

    @classmethod
    def say(cls, text: str, level: int, kind: type[Warning] = UserWarning) -> None:
        """Tell something; ``level``: how many calls up, this one counted, a Python warning points."""
        if cls.tell is None:
            warnings.warn(text, kind, stacklevel=level)
        else:
            cls.tell(text)
