"""Folders for caches of code: written by this user alone, or a temporary one."""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from cnnsim.support.notices import Notices

_GROUP_WRITES, _OTHERS_WRITE = 0o020, 0o002
_PROBE = b"\0" * 8192
"""Written to see whether a folder can be used: on a full disk a file can be made, but not filled."""


def is_private(path: Path) -> bool:
    """Return whether a file or folder belongs to this user, and nobody else can write it.

    Where users have groups of their own, new files can be written by the group: that is nobody else.
    """
    if not hasattr(os, "geteuid"):  # systems without such owners
        return True
    found = path.stat()
    if found.st_uid != os.geteuid() or found.st_mode & _OTHERS_WRITE:
        return False
    return not found.st_mode & _GROUP_WRITES or _is_of_one(found.st_gid)


def _is_of_one(group: int) -> bool:
    """Return whether a group is this user's own: their first one, of their name, with no other member.

    A group such as "users", the first one of many, lists no members either, so the name counts; as pam_umask has it,
    root has no such group: containers under any user's number have root's.
    """
    import grp  # not on every system
    import pwd

    try:
        user, of = pwd.getpwuid(os.geteuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return group != 0 and group == user.pw_gid and of.gr_name == user.pw_name and {*of.gr_mem} <= {user.pw_name}


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

    A folder that others can write is not used: who can write it could have put code there.
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
    Notices.once(f"{what} are made anew each time: no folder to keep them in ({'; '.join(reasons)})")
    return temporary
