"""Exclusive output files: created new, locked while open, and replacing an existing file only on request."""

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cnnsim.support.errors import InputError


def lock(file: int, shared: bool = False) -> bool:
    """Lock an open file until it is closed; return False if another program holds the lock.

    Several readers may hold a ``shared`` lock. Systems and disks without locks always return True.
    """
    try:
        import fcntl
    except ImportError:  # Windows does not let another program replace an open file
        return True
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def refuse_existing(path: Path, replace: bool = False) -> None:
    """Check that a file may be created, or replaced if ``replace`` is true.

    Raises:
        InputError: the name is taken; to be replaced is no plain file, or one that another program has locked.
    """
    if not os.path.lexists(path):
        return
    if not replace:
        raise InputError(f"{path}: there is something of that name; another name or --replace wanted")
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise InputError(f"{path}: no plain file; a plain file or a new name wanted")
    with open_shut(path) as file:
        if not lock(file):
            raise InputError(f"{path}: another program is writing or sending it; another name wanted")


@contextmanager
def open_shut(path: Path) -> Iterator[int]:
    """Yield the descriptor of a file that is open for reading."""
    file = os.open(path, os.O_RDONLY)
    try:
        yield file
    finally:
        os.close(file)


def name_beside(path: Path) -> Path:
    """Return an unused name in the same folder, with the same suffix."""
    return path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")


class NewFile:
    """A new file, locked until it is closed; ``number`` is its descriptor, open for writing.

    If it replaces a file it has a temporary name in the same folder until `settle`.

    Raises:
        InputError: as `refuse_existing`.
        OSError: it cannot be created.
    """

    def __init__(self, path: Path, replace: bool = False) -> None:
        refuse_existing(path, replace)
        self._path = path
        self._at = name_beside(path) if path.exists() else path
        try:
            self.number = os.open(self._at, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            refuse_existing(path)
            raise
        lock(self.number)

    def settle(self) -> None:
        """Rename the file to the path that was asked for."""
        if self._at != self._path:
            refuse_existing(self._path, replace=True)
            self._at.replace(self._path)
            self._at = self._path

    def discard(self) -> None:
        """Close and delete the file."""
        os.close(self.number)
        with suppress(OSError):
            self._at.unlink(missing_ok=True)
