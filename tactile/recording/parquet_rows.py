"""Parquet file written row by row: frames of a recording, figures of a run."""

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pyarrow as pa  # type: ignore[import-untyped]  # it ships no types
from pyarrow import parquet

BATCH = 4096
"""Rows per batch."""
TYPES = {
    float: pa.float64(), int: pa.int64(), str: pa.string(), list[float]: pa.list_(pa.float64()),
    list[bool]: pa.list_(pa.bool_()),
}  # fmt: skip
"""Arrow's types of the kinds that a column may be of."""


class ParquetRows:
    """A Parquet file that grows by rows and is complete when the block ends; it may have no rows.

    Arguments: ``path`` of the file; ``columns``: name and kind (a key of `TYPES`) of each; ``metadata`` of the file.

    Raises:
        OSError: the file cannot be written.
    """

    def __init__(self, path: Path, columns: Mapping[str, Any], metadata: Mapping[bytes, bytes] | None = None) -> None:
        self._columns = pa.schema([(name, TYPES[kind]) for name, kind in columns.items()], metadata=metadata)
        self._out = parquet.ParquetWriter(path, self._columns)
        self._rows: list[tuple[Any, ...]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if not isinstance(error, OSError):
                self._flush()
        finally:
            self._out.close()

    def __call__(self, *row: Any) -> None:
        """Add a row: a value or None for each column, in their order."""
        self._rows.append(row)
        if len(self._rows) == BATCH:
            self._flush()

    def _flush(self) -> None:
        if self._rows:
            cells = zip(*self._rows, strict=True)
            columns = [pa.array(list(column), one.type) for column, one in zip(cells, self._columns, strict=True)]
            self._out.write_table(pa.Table.from_arrays(columns, schema=self._columns))
            self._rows = []
