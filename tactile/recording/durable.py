"""Durable file: complete up to its last push, after a crash of the program or a full disk."""

import os
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.exclusive_file import NewFile


class DurableFile:
    """Collects bytes and writes them in atomic pushes.

    Pushed bytes survive the end of the program. A push that fails, as on a full disk, is rolled back, so that the file
    ends with the last complete one; ``failed`` is the reason, and later writes are ignored. An existing file is kept,
    unless ``replace``: then it is replaced by `settle`. While the file is open, other programs of this kind refuse to
    open it.

    Raises:
        InputError: the file cannot be made, or its name is taken.
    """

    def __init__(self, path: Path, replace: bool = False) -> None:
        self.failed = ""
        self._path, self._pending, self._whole = path, bytearray(), 0
        try:
            self._file = NewFile(path, replace)
        except OSError as error:
            raise InputError(f"cannot write the recording {path}: {error.strerror}") from error

    def write(self, data: bytes) -> int:
        """Collect bytes."""
        if not self.failed:
            self._pending += data
        return len(data)

    def tell(self) -> int:
        """Return the length of the file after the next push."""
        return self._whole + len(self._pending)

    def flush(self) -> None:
        """Do nothing, because only `push` writes."""

    def push(self) -> None:
        """Write the collected bytes."""
        if self.failed or not self._pending:
            return
        data = bytes(self._pending)
        self._pending.clear()
        done = 0
        try:
            while done < len(data):
                done += os.write(self._file.number, data[done:])
        except OSError as error:
            self.failed = error.strerror or str(error)
            if done:
                os.ftruncate(self._file.number, self._whole)
            return
        self._whole += len(data)

    def settle(self) -> None:
        """Push for the first time, then take the place of a file to be replaced.

        Raises:
            InputError: the push fails; the new file is removed.
        """
        self.push()
        try:
            if not self.failed:
                self._file.settle()
                return
        except OSError as error:
            self.failed = error.strerror or str(error)
        except InputError:
            self._file.discard()
            raise
        self._file.discard()
        raise InputError(f"cannot write the recording {self._path}: {self.failed}")

    def close(self) -> None:
        """Push and close."""
        self.push()
        os.close(self._file.number)
