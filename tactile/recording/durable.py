"""A file that is whole up to its last push, whatever happens to the program or the disk."""

import os
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.exclusive_file import NewFile


class DurableFile:
    """Collects bytes and hands them to the operating system in pushes, each of which is there or is not.

    What has been pushed survives the end of the program. A push that fails, as on a full disk, is taken back, so that
    the file ends where the last good one did; ``failed`` says why, and nothing is written any more. No file that was
    there is touched, unless it is to ``replace``: then it is replaced when this one `settle`s. While it is open,
    other programs of this kind leave it alone.

    Raises:
        InputError: the file cannot be made, or something of that name is there.
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
        """Return how long the file will be."""
        return self._whole + len(self._pending)

    def flush(self) -> None:
        """Do nothing: only `push` writes."""

    def push(self) -> None:
        """Hand over what was collected."""
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
        """Push for the first time, and only then take the place of a file that is to be replaced.

        Raises:
            InputError: not even that can be written; nothing is left of it.
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
