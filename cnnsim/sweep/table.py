"""Table of a sweep: rows in Parquet parts while it runs, one file at the end; a part is there whole or not at all."""

import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.extras import install_line
from cnnsim.support.files import make_folder, telling_nobody, writing
from cnnsim.support.interrupts import foreign_call
from cnnsim.support.limits import one_line
from cnnsim.sweep.kind import Row

NUMBER = "case"
"""The column that says which case a row is of."""


class SweepTable:
    """The rows of one sweep in a folder; what is there from an earlier run that was stopped is gone on with.

    Raises:
        InputError: the folder has another sweep's rows, or cannot be written; pyarrow is missing.
    """

    def __init__(self, folder: Path, digest: str) -> None:
        self._arrow, self._parquet = _libraries()
        self.folder, self._parts = folder, folder / "parts"
        self.file = folder / "table.parquet"
        make_folder(self._parts)
        mark = folder / "sweep.json"
        if mark.exists():
            try:
                known = json.loads(mark.read_text(encoding="utf-8"))["digest"]
            except (OSError, ValueError, KeyError, TypeError) as error:
                raise InputError(f"{mark}: not the mark of a sweep; another folder wanted") from error
            if known != digest:
                raise InputError(f"{folder} has the rows of another sweep; a folder for each wanted")
        else:
            if any(self._parts.iterdir()) or self.file.exists():
                raise InputError(f"{folder} has a table that is not this sweep's; a folder of its own wanted")
            with writing(mark) as beside:
                beside.write_text(json.dumps({"digest": digest}), encoding="utf-8")
        known = [part.stem for part in self._parts.glob("*.parquet")]
        if strange := [name for name in known if not name.isdecimal()]:
            raise InputError(f"{self._parts}: {strange[0]}.parquet is no part of a sweep; a folder of its own wanted")
        self._next = 1 + max((int(name) for name in known), default=-1)

    def prepare(self) -> None:
        """Have imported what pyarrow imports for its first table: a quarter of a second, for which all would wait.

        In a thread: a process that is stopped does not wait for it; where one ends otherwise the import may be refused.
        """
        with foreign_call(), suppress(RuntimeError):
            self._arrow.table({NUMBER: self._arrow.array([0])})

    def done(self) -> set[int]:
        """Return the numbers of the cases that have a row."""
        files = [self.file] if self.file.exists() else []
        found: set[int] = set()
        for file in [*files, *self._parts.glob("*.parquet")]:
            with one_line(file, "a part of a sweep"):
                found |= set(self._parquet.read_table(file, columns=[NUMBER])[NUMBER].to_pylist())
        return found

    def add(self, rows: Sequence[Row]) -> None:
        """Write rows as one more part."""
        if rows:
            self._write(rows, self._parts / f"{self._next:08d}.parquet")
            self._next += 1

    def rows(self) -> list[Row]:
        """Return all rows, in the order of the cases; a column that a row lacks is None in it."""
        files = [self.file] if self.file.exists() else []
        parts = [self._parquet.read_table(file).to_pylist() for file in [*files, *sorted(self._parts.glob("*"))]]
        by_case = {row[NUMBER]: row for part in parts for row in part}
        names = list(dict.fromkeys(name for row in by_case.values() for name in row))
        return [{name: by_case[number].get(name) for name in names} for number in sorted(by_case)]

    def finish(self) -> list[Row]:
        """Write the parts as one file, ordered by case, and return the rows."""
        rows, parts = self.rows(), list(self._parts.glob("*.parquet"))
        if parts:
            with telling_nobody():  # it is the same table, grown
                self._write(rows, self.file)
        for part in parts:
            part.unlink()
        return rows

    def _write(self, rows: Sequence[Row], path: Path) -> None:
        names = list(dict.fromkeys(name for row in rows for name in row))
        columns = {name: self._arrow.array(_column([row.get(name) for row in rows])) for name in names}
        with writing(path) as beside:
            self._parquet.write_table(self._arrow.table(columns), beside)


def _column(values: Iterable[Any]) -> list[Any]:
    """Return values of one type: lists and tables as JSON, whole numbers among others as floats, mixtures as texts."""
    plain = [json.dumps(value) if isinstance(value, list | dict | tuple) else value for value in values]
    types = {type(value) for value in plain if value is not None}
    if types == {int, float}:
        return [None if value is None else float(value) for value in plain]
    return plain if len(types) <= 1 else [None if value is None else str(value) for value in plain]


def _libraries() -> tuple[Any, Any]:
    try:
        import pyarrow  # type: ignore[import-untyped]  # it ships no types; slow to import, and only sweeps need it here
        import pyarrow.parquet  # type: ignore[import-untyped]  # the same
    except ImportError as error:
        raise InputError(f"a sweep writes Parquet with pyarrow, which is missing: {install_line('scale')}") from error
    return pyarrow, pyarrow.parquet
