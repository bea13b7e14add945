"""Folders of the library: the shipped one, then users' own; a file in a later folder replaces one of the same name."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from os.path import lexists
from pathlib import Path

from cnnsim.support import InputError

_own: tuple[Path, ...] = ()


def folder() -> Path:
    """Return the folder of the shipped template files: inside an installed package, or next to it in a checkout."""
    inside = Path(__file__).parents[1] / "templates"
    return inside if inside.is_dir() else Path(__file__).parents[2] / "templates"


def folders() -> tuple[Path, ...]:
    """Return all folders, the shipped one first."""
    return (folder(), *_own)


def files() -> dict[str, Path]:
    """Return the file of every template name in alphabetical order, from the last folder that has it."""
    found = {path.stem: path for place in folders() for path in place.glob("*.toml")}
    return dict(sorted(found.items()))


def file_of(name: str) -> Path | None:
    """Return the file of one template name, or None."""
    places = (place / f"{name}.toml" for place in reversed(folders()))
    return next((path for path in places if path.stem == name and lexists(path)), None)


def programs() -> dict[str, Path]:
    """Return the file of every program name, in alphabetical order, from the ``programs`` folders of all folders."""
    found = {path.stem: path for place in folders() for path in (place / "programs").glob("*.toml")}
    return dict(sorted(found.items()))


def program_file(name: str) -> Path:
    """Return the file of a program of the library, from the last folder that has it under ``programs``.

    Raises:
        InputError: there is none; the message has the nearest names.
    """
    found = programs()
    if name in found:
        return found[name]
    raise not_found("program", name, found, "cnnsim list --programs")


def not_found(what: str, name: str, found: Collection[str], command: str) -> InputError:
    """Return the error for an unknown name, with the nearest names and the command that lists all."""
    if what == "template" and name in programs():
        return InputError(f"no template {name!r}, but a program of that name: `cnnsim program {name}` runs it")
    if what == "program" and name in files():
        return InputError(f"no program {name!r}, but a template of that name: `cnnsim run {name}` runs it")
    others = sorted(set(programs()) - set(found)) if what == "template" else []
    near = get_close_matches(name.lower(), [*found, *others], n=3, cutoff=0.4)
    words = [f"the program {match}" if match in others else match for match in near]
    hint = f"; did you mean {' or '.join(words)}?" if near else ""
    return InputError(f"no {what} {name!r} in the library{hint or ';'} `{command}` shows all {len(found)}")


def add(*paths: str | Path) -> None:
    """Add folders of template files to the library; later ones have precedence.

    A file may have the name of a shipped template, which it replaces, and need not have a worked example.

    Raises:
        InputError: one of them is no folder.
    """
    global _own
    for path in map(Path, paths):
        if not path.is_dir():
            raise InputError(f"library {path} does not exist; a folder of template files wanted")
        place = path.resolve()
        _own = (*(other for other in _own if other != place), place)


@contextmanager
def using(*paths: str | Path) -> Iterator[None]:
    """Add folders as `add` does, for a ``with`` block."""
    global _own
    before = _own
    try:
        add(*paths)
        yield
    finally:
        _own = before
