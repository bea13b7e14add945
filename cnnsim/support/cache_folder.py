"""Folders for caches of compiled code: only this user can write them."""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from cnnsim.support.notices import Notices

_OTHERS_WRITE = 0o022
_PROBE = b"\0" * 8192
"""Written to see whether a folder can be used: on a full disk a file can be made, but not filled."""


def is_private(folder: Path) -> bool:
    """Return whether a folder belongs to this user, and no group and no other user can write it."""
    if not hasattr(os, "geteuid"):  # systems without such owners
        return True
    found = folder.stat()
    return found.st_uid == os.geteuid() and not found.st_mode & _OTHERS_WRITE


def user_cache() -> Path:
    """Return the folder for the caches of a user's programs."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~")).expanduser()
    usual = "~/Library/Caches" if sys.platform == "darwin" else "~/.cache"
    with suppress(RuntimeError):  # no home
        return Path(os.environ.get("XDG_CACHE_HOME") or usual).expanduser()
    return Path(usual)


def first_usable(candidates: Sequence[Path], what: str) -> Path:
    """Return the first private folder that can be written; if there is none, a temporary one, with a notice.

    Cached code in a folder that others can write could be theirs.
    """
    reasons = []
    for folder in candidates:
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not is_private(folder):
                reasons.append(f"{folder}: others can write it, or own it")
                continue
            with tempfile.TemporaryFile(dir=folder) as probe:
                probe.write(_PROBE)
            return folder
        except OSError as error:
            reasons.append(f"{folder}: {error.strerror}")
    temporary = Path(tempfile.mkdtemp(prefix="cnnsim-"))
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    Notices.once(f"{what} are compiled again each time: no folder to keep them in ({'; '.join(reasons)})")
    return temporary
