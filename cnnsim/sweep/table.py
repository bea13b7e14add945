"""Table of a sweep: its rows in one Parquet file, which is rewritten at intervals; a stopped sweep resumes from it."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.command_files import own_files
from cnnsim.support.extras import install_line
from cnnsim.support.files import make_folder, writing
from cnnsim.support.limits import one_line
from cnnsim.sweep.kind import Row

NUMBER = "case"
"""The column with the number of the case."""
MARK = b"sweep"
"""Key of the file's metadata with the digest of the sweep."""
INTERVAL, SHARE = 5.0, 0.05
"""Seconds between two writes, at least; and the share of the time that writing may take."""


class SweepTable:
    """The ``rows`` of one sweep by the number of their case, and their ``file`` in a folder.

    Raises:
        InputError: the folder has the table of another sweep, or cannot be written; pyarrow is missing.
    """

    def __init__(self, folder: Path, digest: str) -> None:
        self._arrow, self._parquet = _libraries()
        self.file, self._digest = folder / "table.parquet", digest
        self.rows: dict[int, Row] = {}
        make_folder(folder)
        if self.file.exists():
            with one_line(self.file, "the table of a sweep"):
                found = self._parquet.read_table(self.file)
                self.rows = {row[NUMBER]: row for row in found.to_pylist()}
            if (found.schema.metadata or {}).get(MARK) != digest.encode():
                raise InputError(f"{folder} has the table of another sweep; a folder for each wanted")
        self._written, self._took = perf_counter(), 0.0

    def add(self, rows: Sequence[Row]) -> None:
        """Add rows, and write the file if the last write is long enough ago."""
        self.rows |= {row[NUMBER]: row for row in rows}
        if perf_counter() - self._written > max(INTERVAL, self._took / SHARE):
            self.write()

    def sorted_rows(self) -> list[Row]:
        """Return all rows in the order of the cases; a column that a row lacks is None in it."""
        names = list(dict.fromkeys(name for row in self.rows.values() for name in row))
        return [{name: self.rows[number].get(name) for name in names} for number in sorted(self.rows)]

    def write(self) -> None:
        """Write the table to a new file and replace the file with it."""
        begun, rows = perf_counter(), self.sorted_rows()
        columns = {name: self._arrow.array(_column([row[name] for row in rows])) for name in (rows[0] if rows else {})}
        table = self._arrow.table(columns).replace_schema_metadata({MARK: self._digest.encode()})
        with own_files(), writing(self.file) as temporary:
            self._parquet.write_table(table, temporary)
        self._written = perf_counter()
        self._took = self._written - begun


def _column(values: Iterable[Any]) -> list[Any]:
    """Return values of one type: lists and tables as JSON, whole numbers among floats as floats, mixtures as texts."""
    plain = [json.dumps(value) if isinstance(value, list | dict | tuple) else value for value in values]
    types = {type(value) for value in plain if value is not None}
    if types == {int, float}:
        return [None if value is None else float(value) for value in plain]
    return plain if len(types) <= 1 else [None if value is None else str(value) for value in plain]


def _libraries() -> tuple[Any, Any]:
    try:
        import pyarrow  # type: ignore[import-untyped]  # ships no types; slow to import
        import pyarrow.parquet  # type: ignore[import-untyped]  # the same
    except ImportError as error:
        raise InputError(f"a sweep writes Parquet with pyarrow, which is missing: {install_line('scale')}") from error
    return pyarrow, pyarrow.parquet
