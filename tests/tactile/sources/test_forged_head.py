"""Recordings whose header declares larger arrays than their frames: refused with both sizes, before allocation."""

import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]  # it ships no types
import pytest

from cnnsim.support import InputError
from tactile import Frame, TaxelArray, open_source
from tactile.core.source import FrameStream
from tactile.sources.replay_csv import write_csv
from tactile.sources.replay_npz import write_npz
from tactile.sources.replay_parquet import write_parquet


def source() -> FrameStream:
    array = TaxelArray("pad", 2, 2, pitch=1e-3, depth=1e-3)
    frames = [Frame(0, 0.01 * k, k, np.full((2, 2, 3), 1e-3 * k), np.ones((2, 2), bool)) for k in range(20)]
    return FrameStream("pad", (array,), 2e6, len(frames), frames)


def enlarge(text: str, rows: int, cols: int) -> str:
    return text.replace("rows = 2\n", f"rows = {rows}\n").replace("cols = 2\n", f"cols = {cols}\n")


def forge(path: Path, rows: int, cols: int) -> None:
    """Write a recording of 2 x 2 taxels whose header declares another shape."""
    kind = path.suffix
    if kind == ".csv":
        write_csv(path, source())
        path.write_text(enlarge(path.read_text(), rows, cols))
    elif kind == ".npz":
        write_npz(path, source())
        arrays = dict(np.load(path))
        arrays["tactile"] = np.array(enlarge(str(arrays["tactile"]), rows, cols))
        np.savez(path, **arrays)
    else:
        write_parquet(path, source())
        table = pq.read_table(path)
        head = {key: enlarge(value.decode(), rows, cols).encode() for key, value in table.schema.metadata.items()}
        pq.write_table(table.replace_schema_metadata(head), path)


MESSAGES = {
    ".csv": "the column names .* wanted: 3145733, not 17",
    ".npz": r"values of shape \(20, 2, 2, 3\).*\(20, 1024, 1024, 3\)",
    ".parquet": "12 values and 4 flags, 3145728 and 1048576 of 1024 x 1024 taxels wanted",
}


@pytest.mark.parametrize("kind", MESSAGES)
def test_a_header_of_giant_arrays_is_refused_before_allocation(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"forged{kind}"
    forge(path, 2, 2)
    assert sum(1 for _ in open_source(path)) == 20
    path.unlink()
    forge(path, 1024, 1024)
    tracemalloc.start()
    with pytest.raises(InputError, match=MESSAGES[kind]) as caught:
        open_source(path)
    assert tracemalloc.get_traced_memory()[1] < 4e6
    tracemalloc.stop()
    assert len(str(caught.value)) < 600
