"""Catalogue of the library: templates by name, and runs of them as their files specify."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, Unpack

from numpy.typing import ArrayLike

from cnnsim.backends.base import Backend
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.library.folders import file_of, files, not_found
from cnnsim.library.read import load_file
from cnnsim.network import AnyTemplate
from cnnsim.recording import Record
from cnnsim.result import Result
from cnnsim.support import InputError
from cnnsim.support.keywords import spelled
from cnnsim.task import Dtype, TaskOptions
from cnnsim.transient import run_transient


@spelled(TaskOptions)
def run(
    entry: LibraryEntry | str, picture: ArrayLike, *, state: ArrayLike | None = None, backend: str | Backend = "cpu",
    dtype: Dtype | None = None, threads: int | None = None, record: Record | None = None,
    **changes: Unpack[TaskOptions],
) -> Result:  # fmt: skip
    """Run a library template on a picture (rows, cols) of CNN values as its file specifies.

    ``state`` is the second picture of templates that take one. ``changes`` replace values of the file: boundary,
    duration, cell, scheme, step, accuracy, limit, bias, mask, as in `run_transient`; so are ``backend``, ``dtype``,
    ``threads``. ``record``: times [time constants] or cells (row, column) of which the result has a ``trajectory``.

    Raises:
        InputError: no such template, no picture, a missing second picture; as `run_transient`.
        NotSettledError: as `run_transient`.
    """
    entry = load(entry) if isinstance(entry, str) else entry
    if not isinstance(entry, LibraryEntry):
        cure = "; run_transient(template, state=..., input=...) runs one" if isinstance(entry, AnyTemplate) else ""
        raise InputError(f"{type(entry).__name__} {entry!r}; the name of a library template, or an entry, wanted{cure}")
    task = entry.changed(entry.task(picture, state), changes)
    return run_transient(entry.network, **task, backend=backend, dtype=dtype, threads=threads, record=record)


def run_example(entry: LibraryEntry, example: Example, backend: str | Backend = "cpu", **changes: Any) -> Result:
    """Run a template on one of its own examples."""
    picture = example.state if example.input is None else example.input
    given = "given" in entry.initial_state if isinstance(entry.initial_state, tuple) else entry.initial_state == "given"
    second = example.state if given else None
    assert picture is not None
    return run(entry, picture, state=second, backend=backend, mask=example.mask, bias=example.bias, **changes)


def names(tag: str | None = None) -> list[str]:
    """Return the names of all templates, or of those with a tag, in alphabetical order."""
    return list(files()) if tag is None else [entry.name for entry in sound()[0] if tag in entry.tags]


def sound() -> tuple[list[LibraryEntry], dict[Path, InputError]]:
    """Return all valid templates in alphabetical order, and the errors of the other files."""
    entries, broken = [], {}
    for path in files().values():
        try:
            entries.append(_load(path))
        except InputError as error:
            broken[path] = error
    return entries, broken


def load(name: str) -> LibraryEntry:
    """Return the library template ``name`` from the last folder that has it, or the template of a file `x.toml`.

    Raises:
        InputError: there is none (the message has the nearest names), or its file is wrong.
    """
    if not isinstance(name, str):
        raise InputError(f"template {name!r}; the name of one of the library, or of a file, wanted")
    path = Path(name) if name.endswith(".toml") else file_of(name) or _by_alias(name)
    if path is None:
        raise not_found("template", name, names(), "cnnsim list")
    return _load(path)


def has_template(name: str) -> bool:
    """Return whether a template has the name or the alias."""
    return name in files() or _by_alias(name) is not None


def _load(path: Path) -> LibraryEntry:
    try:
        return _load_once(path, path.stat().st_mtime_ns)
    except OSError:  # a broken link, a closed folder: the reader reports it
        return load_file(path)


def _by_alias(alias: str) -> Path | None:
    """Return the file of the template with an alias, in any case of letters."""
    named = (entry.file for entry in sound()[0] if alias.lower() in map(str.lower, entry.aliases))
    return next(named, None)


@cache
def _load_once(path: Path, changed: int) -> LibraryEntry:
    """Load a file again only when it has changed."""
    return load_file(path)
