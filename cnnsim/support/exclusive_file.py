"""Files that grow while others look: made new, locked as long as they are open, put over another only on request."""

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cnnsim.support.errors import InputError


def lock(file: int, shared: bool = False) -> bool:
    """Lock an open file against those who lock it too, for as long as it is open; return False where one of them has.

    A ``shared`` lock is kept by readers, several at a time. Systems and disks without locks always say yes.
    """
    try:
        import fcntl
    except ImportError:  # Windows lets nobody replace a file that is open
        return True
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def refuse_existing(path: Path, replace: bool = False) -> None:
    """Refuse a name that is taken; where it may be replaced, one that is no plain file or is in use.

    Raises:
        InputError: so it is.
    """
    if not os.path.lexists(path):
        return
    if not replace:
        raise InputError(f"{path}: there is something of that name; another name or --replace wanted")
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise InputError(f"{path}: no plain file; only such are replaced")
    with open_shut(path) as file:
        if not lock(file):
            raise InputError(f"{path}: another program is writing or sending it; another name wanted")


@contextmanager
def open_shut(path: Path) -> Iterator[int]:
    """Give the number of a file that is open for reading during the block."""
    file = os.open(path, os.O_RDONLY)
    try:
        yield file
    finally:
        os.close(file)


def name_beside(path: Path) -> Path:
    """Return an unused name in the same folder, with the same suffix."""
    return path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")


class NewFile:
    """A file made for this program alone and locked until it is closed: its ``number``, open for writing.

    Where it is to replace another it stands beside that until `settle`.

    Raises:
        InputError: as `refuse_existing`.
        OSError: it cannot be made.
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
        """Give it the name that it was asked for."""
        if self._at != self._path:
            refuse_existing(self._path, replace=True)
            self._at.replace(self._path)
            self._at = self._path

    def discard(self) -> None:
        """Close it and take it away, as if it had never been."""
        os.close(self.number)
        with suppress(OSError):
            self._at.unlink(missing_ok=True)
