"""Output files, written under a temporary name and renamed when complete; checks of paths and names."""

import csv
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cnnsim.support.command_files import CommandFiles, check_free
from cnnsim.support.errors import InputError, shown


def named_file(path: Any) -> Path:
    """Return the path that a caller gave.

    Raises:
        InputError: it is no path, such as a number or an open file.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path {shown(path)}; the name of a file wanted")
    return Path(path)


@contextmanager
def writing(path: str | Path, *, replace: bool | None = None, follow: bool = True) -> Iterator[Path]:
    """Yield a temporary path; it is renamed to ``path`` when the block succeeds, and removed when it fails.

    The temporary path has the name of ``path``, whose ending decides the format, in a new folder next to it. A device
    or a pipe is written directly. A symbolic link is followed; without ``follow`` it is replaced, for folders in which
    names come from a file. ``replace``: an existing file may be replaced; if None, commands need --replace for it.

    Raises:
        InputError: no path; the file exists and may not be replaced; it cannot be written; it is an input or another
            output of the running command.
    """
    target, files = named_file(path), CommandFiles.current
    if files is not None:
        files.begin(target, replace)
    check_free(target, replace=files is not None or replace is not False)
    try:
        if target.exists() and not target.is_file() and (follow or not target.is_symlink()):
            if target.is_dir():
                raise InputError(f"cannot write {path}: there is a folder of that name")
            yield target
            return
        there = target.exists()
        place = target.resolve() if follow else target.absolute()
        with TemporaryDirectory(prefix=f".{target.stem[:40]}-", dir=place.parent) as folder:
            temporary = Path(folder) / target.name
            try:
                yield temporary
            except InputError as error:
                said = str(error).replace(str(temporary), str(path))  # users know only the name that they gave
                if said != str(error):
                    raise InputError(said) from error
                raise
            if there:
                temporary.chmod(place.stat().st_mode & 0o777)
            temporary.replace(place)
    except InputError:
        raise
    except (OSError, ValueError, RuntimeError) as error:  # an ending that the writer does not know; a looping link
        raise InputError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from error
    if files is not None:
        files.end(target, replaced=there)


def check_place(*paths: Path | None) -> None:
    """Check, before a long computation, that `writing` can write files; None is skipped.

    Raises:
        InputError: a folder has the name; the parent folder is missing or not writable.
    """
    for path in paths:
        if path is None:
            continue
        if path.is_dir():
            raise InputError(f"cannot write {path}: there is a folder of that name")
        if not path.parent.is_dir():
            raise InputError(f"cannot write {path}: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK | os.X_OK) and not path.exists():  # a device may be written in its place
            raise InputError(f"cannot write {path}: the folder {path.parent} is closed")


def check_folder(folder: Path) -> None:
    """Check, before a long computation, that `make_folder` can make a folder.

    Raises:
        InputError: something in the path is no folder.
    """
    for place in (folder, *folder.parents):
        if place.exists() or place.is_symlink():
            if not place.is_dir():
                raise InputError(f"cannot make the folder {folder}: {place} is no folder")
            return


def write_text(path: str | Path, text: str, *, replace: bool | None = None, follow: bool = True) -> None:
    """Write a text file (UTF-8) with `writing`, and make its parent folders.

    Raises:
        InputError: as `writing`.
    """
    make_folder(Path(path).parent)
    with writing(path, replace=replace, follow=follow) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_rows(path: str | Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a CSV file with `writing`; the keys of the first row are the columns.

    Raises:
        InputError: as `writing`.
    """
    with writing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def make_folder(folder: Path) -> None:
    """Make a folder and its parents.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


LONGEST_NAME = 100
"""Characters of a name, so that it is a valid file name with a suffix on all systems."""
_NAME = re.compile(rf"[A-Za-z0-9_][A-Za-z0-9_-]{{0,{LONGEST_NAME - 1}}}", re.ASCII)


def check_name(name: str, what: str) -> str:
    """Return a name that files give and that becomes the name of a file.

    Raises:
        InputError: it has other characters than letters, digits, - and _, begins with -, is empty or too long.
    """
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{what} {name[: LONGEST_NAME + 1]!r}; letters, digits, - and _ wanted, not - first, {LONGEST_NAME} at most"
        )
    return name
