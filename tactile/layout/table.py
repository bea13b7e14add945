"""Tables of foreign files: named columns over the samples of a file, read by the library of its format."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.errors import nearest

if TYPE_CHECKING:
    from tactile.layout.layout import Layout

EXTRA = "tables"
"""Extra of pip with the libraries of the readers."""
TEXT, ARRAYS, MESSAGES = "tactile.layout.text_table", "tactile.layout.array_tables", "tactile.layout.message_table"
READERS = {
    ".csv": (TEXT, "read_text"), ".tsv": (TEXT, "read_text"), ".txt": (TEXT, "read_text"),
    ".dat": (TEXT, "read_text"), ".log": (TEXT, "read_text"), ".npy": (ARRAYS, "read_npy"),
    ".npz": (ARRAYS, "read_npz"), ".mat": (ARRAYS, "read_mat"), ".h5": (ARRAYS, "read_hdf5"),
    ".hdf5": (ARRAYS, "read_hdf5"), ".parquet": (ARRAYS, "read_parquet"), ".mcap": (MESSAGES, "read_messages"),
    ".bag": (MESSAGES, "read_messages"), ".db3": (MESSAGES, "read_messages"),
}  # fmt: skip
"""Suffix -> module and function of the reader, which is imported when used."""
MOST_NAMES = 12
"""Largest number of names in a message."""


@dataclass(frozen=True)
class Table:
    """The contents of a file: ``columns`` name -> array (samples, ...) of numbers or texts, in the order of the file.

    ``notes``: sentences about contents that are no columns; ``topic`` of messages.
    """

    path: Path
    columns: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    topic: str = ""

    def __repr__(self) -> str:
        return f"Table({self.path.name}: {self.names})"

    @property
    def names(self) -> str:
        """The names and shapes of the columns, cut to a line."""
        said = [
            name if one.ndim == 1 else f"{name} ({' x '.join(map(str, one.shape))})"
            for name, one in self.columns.items()
        ]
        more = f" and {len(said) - MOST_NAMES} more" if len(said) > MOST_NAMES else ""
        return ", ".join(said[:MOST_NAMES]) + more

    def take(self, name: str | int, what: str) -> Any:
        """Return a column by its name or its number from 0.

        Raises:
            InputError: no such column; ``what`` leads the message.
        """
        if isinstance(name, int):
            if not 0 <= name < len(self.columns):
                raise InputError(f"{what} {name}: {self.path.name} has {len(self.columns)} columns, numbered from 0")
            return list(self.columns.values())[name]
        if name not in self.columns:
            near = nearest(name, self.columns.keys())
            hint = f"; did you mean {near!r}?" if near else ""
            raise InputError(f"{what} {name!r}: no such column; {self.path.name} has {self.names}{hint}")
        return self.columns[name]

    def numbers(self, name: str | int, what: str) -> Any:
        """Return a column of numbers.

        Raises:
            InputError: as `take`, or a column of texts.
        """
        found = self.take(name, what)
        if found.dtype.kind not in "biuf":
            raise InputError(f"{what} {name!r}: {self.path.name} has texts in it, such as {str(found.flat[0])!r}")
        return found

    def matching(self, pattern: str) -> list[str]:
        """Return the names that a pattern with ``*`` and ``?`` matches, a literal name first."""
        if pattern in self.columns:
            return [pattern]
        return [name for name in self.columns if fnmatchcase(name, pattern)]


def read_table(path: Path, layout: "Layout | None" = None) -> Table:
    """Return the table of a file; ``layout`` has its separator, topic and number of lines to skip.

    Raises:
        InputError: an unknown suffix, a missing library, a file that cannot be read, no column in it.
    """
    suffix = ".bag" if path.is_dir() else path.suffix.lower()
    if suffix not in READERS:
        raise InputError(f"{path}: suffix {path.suffix!r}; one of {', '.join(READERS)} wanted")
    module, name = READERS[suffix]
    read: Callable[[Path, Any], Table] = getattr(import_module(module), name)
    table = read(path, layout)
    if not table.columns:
        raise InputError(f"{path}: no column of numbers in it{'; ' if table.notes else ''}{'; '.join(table.notes)}")
    return table


def flat(value: Any, name: str = "") -> dict[str, Any]:
    """Return nested mappings as one, with names joined by dots."""
    if not isinstance(value, Mapping):
        return {name: value}
    out: dict[str, Any] = {}
    for key, one in value.items():
        out |= flat(one, f"{name}.{key}" if name else str(key))
    return out


def usable(columns: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return the arrays of numbers and texts with at least one dimension, and a note on the others."""
    kept, left = {}, []
    for name, one in columns.items():
        array = np.asarray(one)
        if array.ndim and array.size and array.dtype.kind in "biufU":
            kept[name] = array
        else:
            left.append(name)
    return kept, [f"no array of numbers: {', '.join(left[:MOST_NAMES])}"] if left else []
