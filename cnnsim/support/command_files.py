"""Files of the running command: no output is an input, no two outputs are one file, none is overwritten unasked."""

import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import ClassVar

from cnnsim.support.errors import InputError

Key = str | tuple[int, int]


class CommandFiles:
    """Files that the running command reads and writes; in Python, without a command, nothing is recorded.

    Readers call `note_read`, commands `claim` their outputs before the work, and `cnnsim.support.files.writing` calls
    `begin` and `end`. Files are compared by their resolved paths and inodes, so links and relative names count.

    Arguments: ``tell``: called with each file that was overwritten.
    """

    current: ClassVar["CommandFiles | None"] = None

    def __init__(self, tell: Callable[[Path], None]) -> None:
        self.replace, self._tell = False, tell
        self._read: dict[Key, Path] = {}
        self._claimed: dict[Key, Path] = {}
        self._begun: set[Path] = set()
        self._ended: set[Path] = set()

    def read(self, path: Path) -> None:
        """Record an input, unless this command has written it."""
        keys = _keys(path)
        for key in keys:
            if (output := self._claimed.get(key)) is not None:
                if output in self._ended:
                    return
                raise _both(output, path)
        self._read.update(dict.fromkeys(keys, path))

    def claim(self, *paths: Path | None, replace: bool | None = None) -> None:
        """Record outputs that will be written; None is skipped.

        Raises:
            InputError: an output is an input or another output, or it exists and may not be replaced.
        """
        for path in filter(None, paths):
            for key in (*_keys(path), *map(str, Path(os.path.realpath(path)).parents)):
                if key in self._read:  # an input may be a folder, such as a Zarr array or a bag
                    raise _both(path, self._read[key])
            for key in _keys(path):
                if key in self._claimed:
                    raise InputError(f"two outputs are one file: {self._claimed[key]} and {path}; two names wanted")
            self._claimed.update(dict.fromkeys(_keys(path), path))
        check_free(*filter(None, paths), replace=self.replace if replace is None else replace)

    def begin(self, path: Path, replace: bool | None) -> None:
        """Record an output that is written now; errors as `claim`."""
        claimed = {self._claimed[key] for key in _keys(path) if key in self._claimed} - self._begun
        if not claimed:
            self.claim(path, replace=replace)
        self._begun |= claimed or {path}

    def end(self, path: Path, *, replaced: bool) -> None:
        """Record an output that is complete: the command may read it."""
        self._ended |= {self._claimed[key] for key in _keys(path) if key in self._claimed}
        if replaced:
            self._tell(path)


def _keys(path: Path) -> list[Key]:
    """Return what identifies a file: its resolved path, and its inode if it exists; nothing for devices and pipes."""
    keys: list[Key] = [os.path.realpath(path)]
    with suppress(OSError, ValueError):
        found = path.stat()
        if not stat.S_ISREG(found.st_mode) and not stat.S_ISDIR(found.st_mode):
            return []
        keys.append((found.st_dev, found.st_ino))
    return keys


def _both(output: Path, read: Path) -> InputError:
    same = "" if output == read else f" {read}"
    return InputError(f"output {output} is the input{same}, which would be lost; another name wanted")


@contextmanager
def command_files(tell: Callable[[Path], None]) -> Iterator[None]:
    """Record the files of a command in the block."""
    before, CommandFiles.current = CommandFiles.current, CommandFiles(tell)
    try:
        yield
    finally:
        CommandFiles.current = before


@contextmanager
def own_files() -> Iterator[None]:
    """Record nothing in a block, for files of our own that are updated."""
    before, CommandFiles.current = CommandFiles.current, None
    try:
        yield
    finally:
        CommandFiles.current = before


def note_read(path: Path) -> None:
    """Record an input of the running command, if there is one."""
    if CommandFiles.current is not None:
        CommandFiles.current.read(path)


def claim(*paths: Path | None) -> None:
    """Check the outputs of the running command before the work; None is skipped. Errors as `CommandFiles.claim`."""
    if CommandFiles.current is not None:
        CommandFiles.current.claim(*paths)


def check_free(*paths: Path, replace: bool) -> None:
    """Check, before a long computation, that files may be written; devices and pipes may.

    Raises:
        InputError: some of the files exist and ``replace`` is false.
    """
    there = [] if replace else [str(path) for path in paths if path.is_file() or path.is_dir()]
    if there:
        verb, them = ("is", "it") if len(there) == 1 else ("are", "them")
        raise InputError(f"{', '.join(there)} {verb} there already; --replace would write over {them}")
