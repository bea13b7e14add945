"""Files written whole or not at all: beside the target first, then renamed; what was replaced is told."""

import csv
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cnnsim.support.errors import InputError, shown


class Replaced:
    """Who is told of files that were written over: nobody in Python, stderr where a command line sets ``tell``."""

    tell: Callable[[Path], None] | None = None


@contextmanager
def telling_nobody() -> Iterator[None]:
    """Tell nobody of files that are written over in a block: our own, brought up to date."""
    tell, Replaced.tell = Replaced.tell, None
    try:
        yield
    finally:
        Replaced.tell = tell


def named_file(path: Any) -> Path:
    """Return the path that a caller gave.

    Raises:
        InputError: a number, an open file, or whatever else is no name.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path {shown(path)}; the name of a file wanted")
    return Path(path)


@contextmanager
def writing(path: str | Path, *, replace: bool = True, follow: bool = True) -> Iterator[Path]:
    """Give the path to write under; when the block ends well the file is renamed to ``path``, else it is gone.

    It stands in a folder of its own beside the target, under the target's name: the ending decides the format. The
    target's folders are made. A device or a pipe is written to as it is. A link is written through, unless not to
    ``follow``: in a folder where names come from a file, it gives way to the file, wherever it points.

    Raises:
        InputError: no path; the file is there and not to be replaced, or cannot be written.
    """
    target = named_file(path)
    check_free(target, replace=replace)
    try:
        if target.exists() and not target.is_file() and (follow or not target.is_symlink()):
            if target.is_dir():
                raise InputError(f"cannot write {path}: there is a folder of that name")
            yield target
            return
        there = target.exists()
        place = target.resolve() if follow else target.absolute()
        with TemporaryDirectory(prefix=f".{target.stem[:40]}-", dir=place.parent) as folder:
            beside = Path(folder) / target.name
            try:
                yield beside
            except InputError as error:
                said = str(error).replace(str(beside), str(path))  # people know only the name that they gave
                if said != str(error):
                    raise InputError(said) from error
                raise
            if there:
                beside.chmod(place.stat().st_mode & 0o777)
            beside.replace(place)
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a ValueError: an ending that the writer does not know
        raise InputError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from error
    if there and Replaced.tell is not None:
        Replaced.tell(target)


def check_free(*paths: Path, replace: bool) -> None:
    """Refuse before any work is done what `writing` would refuse after it.

    Raises:
        InputError: some of the files are there and not to be replaced.
    """
    there = [] if replace else [str(path) for path in paths if path.exists()]
    if there:
        verb, them = ("is", "it") if len(there) == 1 else ("are", "them")
        raise InputError(f"{', '.join(there)} {verb} there already; --replace would write over {them}")


def check_place(*paths: Path | None) -> None:
    """Refuse before any work is done files that `writing` could not write after it; None is none.

    Raises:
        InputError: a folder has the name, there is no folder to write into, or it is closed.
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
    """Refuse before any work is done a folder that `make_folder` could not make after it.

    Raises:
        InputError: something in the path is no folder.
    """
    for place in (folder, *folder.parents):
        if place.exists() or place.is_symlink():
            if not place.is_dir():
                raise InputError(f"cannot make the folder {folder}: {place} is no folder")
            return


def write_text(path: str | Path, text: str, *, replace: bool = True, follow: bool = True) -> None:
    """Write a text file (UTF-8) as `writing` does, with the folders that lead to it.

    Raises:
        InputError: as `writing`.
    """
    make_folder(Path(path).parent)
    with writing(path, replace=replace, follow=follow) as beside:
        beside.write_text(text, encoding="utf-8")


def write_rows(path: str | Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a CSV file as `writing` does, a row each, under the names of the first one.

    Raises:
        InputError: as `writing`.
    """
    with writing(path) as beside, beside.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def make_folder(folder: Path) -> None:
    """Make a folder and those that lead to it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


LONGEST_NAME = 100
"""Characters of a name: with a folder's and a suffix it still is a file's name everywhere."""
_NAME = re.compile(rf"[A-Za-z0-9_][A-Za-z0-9_-]{{0,{LONGEST_NAME - 1}}}", re.ASCII)


def check_name(name: str, what: str) -> str:
    """Return a name.

    Raises:
        InputError: it has other characters than letters, digits, - and _, begins with -, is empty or too long.
    """
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{what} {name[: LONGEST_NAME + 1]!r}; letters, digits, - and _ wanted, not - first, {LONGEST_NAME} at most"
        )
    return name
