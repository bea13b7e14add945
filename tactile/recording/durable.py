"""A file that is whole up to its last push, whatever happens to the program or the disk."""

import os
from pathlib import Path

from cnnsim.support import InputError


class DurableFile:
    """Collects bytes and hands them to the operating system in pushes, each of which is there or is not.

    What has been pushed survives the end of the program. A push that fails, as on a full disk, is taken back, so that
    the file ends where the last good one did; ``failed`` says why, and nothing is written any more.

    Raises:
        InputError: the file cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.failed = ""
        self._path, self._pending, self._whole = path, bytearray(), 0
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
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
                done += os.write(self._file, data[done:])
        except OSError as error:
            self.failed = f"recording {self._path} ended: {error.strerror}; what was written until then can be read"
            if done:
                os.ftruncate(self._file, self._whole)
            return
        self._whole += len(data)

    def close(self) -> None:
        """Push and close."""
        self.push()
        os.close(self._file)
