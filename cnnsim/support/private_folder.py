"""Folders for caches of code: written by this user alone, or a temporary one."""

import atexit
import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

_OTHERS_WRITE = 0o022
_PROBE = b"\0" * 8192
"""Written to see whether a folder can be used: on a full disk a file can be made, but not filled."""


class Notices:
    """Who is told what the machine lacks: a Python warning, or one line on stderr where a command sets ``tell``."""

    tell: Callable[[str], None] | None = None
    _told: set[str] = set()  # noqa: RUF012 - of the process, as all of this

    @classmethod
    def once(cls, text: str) -> None:
        """Tell something, once a process."""
        if text in cls._told:
            return
        cls._told.add(text)
        if cls.tell is None:
            warnings.warn(text, RuntimeWarning, stacklevel=3)
        else:
            cls.tell(text)


def is_private(path: Path) -> bool:
    """Return whether a file or folder belongs to this user, and nobody else can write it."""
    if not hasattr(os, "geteuid"):  # systems without such owners
        return True
    found = path.stat()
    return found.st_uid == os.geteuid() and not found.st_mode & _OTHERS_WRITE


def user_cache() -> Path:
    """Return the folder in which a user's programs keep what can be made anew."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~")).expanduser()
    usual = "~/Library/Caches" if sys.platform == "darwin" else "~/.cache"
    with suppress(RuntimeError):  # no home
        return Path(os.environ.get("XDG_CACHE_HOME") or usual).expanduser()
    return Path(usual)


def first_usable(candidates: Sequence[Path], what: str) -> Path:
    """Return the first folder that can be used as a cache; a temporary one, with a word, if there is none.

    A folder that others can write is not used, which is said as well: who can write it could have put code there.
    """
    reasons = []
    for folder in candidates:
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not is_private(folder):
                Notices.once(f"{folder} is not used: others can write it, or own it (`chmod go-w` mends the first)")
                continue
            with tempfile.TemporaryFile(dir=folder) as probe:
                probe.write(_PROBE)
            return folder
        except OSError as error:
            reasons.append(f"{folder}: {error.strerror}")
    temporary = Path(tempfile.mkdtemp(prefix="cnnsim-"))
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    Notices.once(f"{what} are made anew each time: no folder to keep them in ({'; '.join(reasons) or 'see above'})")
    return temporary
