"""The files of a store: what Zarr and what our own rows read and write is the same."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim.network import Boundary
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.shards import Shards, can_be_read, create
from cnnsim.supersteps.store import MASK, GridStore
from cnnsim.support import InputError

zarr = pytest.importorskip("zarr")
RANDOM = np.random.default_rng(8)
F4 = np.dtype("f4")


def written(folder: Path, values: Any, side: int) -> Any:
    array = create(zarr.open_group(folder), "a", values.shape, values.dtype, side)
    files, (rows, cols) = Shards(array), values.shape[-2:]
    for r0 in range(0, rows, side):
        for c0 in range(0, cols, side):
            area = (r0, min(r0 + side, rows)), (c0, min(c0 + side, cols))
            files.write(area, values[..., slice(*area[0]), slice(*area[1])])
    return array


@pytest.mark.parametrize(("shape", "side"), [((70, 90), 32), ((300, 20), 300), ((2, 33, 65), 32)])
def test_zarr_reads_what_is_written_as_rows(shape: tuple[int, ...], side: int, tmp_path: Path) -> None:
    values = RANDOM.random(shape, F4)
    array = written(tmp_path, values, side)
    assert array[...].tobytes() == values.tobytes()  # its checksums are right, too
    out = np.empty((*shape[:-2], 20, 13), F4)
    Shards(array).read(out, (11, 31), (5, 18))
    assert np.array_equal(out, values[..., 11:31, 5:18])


def test_arrays_of_zarr_without_shards_are_read_where_they_are(tmp_path: Path) -> None:
    values = RANDOM.random((600, 300), F4)
    group = zarr.open_group(tmp_path)
    plain = group.create_array("plain", shape=values.shape, dtype=F4, chunks=(256, 300), compressors=None)
    plain[:512] = values[:512]  # the last chunks have no file
    packed, tiny = (
        group.create_array(name, shape=values.shape, dtype=F4, chunks=chunks, compressors=compressors)
        for name, chunks, compressors in (("packed", (256, 300), "auto"), ("tiny", (16, 16), None))
    )
    assert [can_be_read(one, F4) for one in (plain, packed, tiny)] == [True, False, False]
    assert not can_be_read(plain, np.dtype("f8"))
    out = np.empty((350, 100), F4)
    Shards(plain).read(out, (250, 600), (200, 300))
    assert np.array_equal(out, plain[250:, 200:])


def test_a_shard_that_is_cut_short_is_told(tmp_path: Path) -> None:
    array = written(tmp_path, np.ones((8, 8), F4), 8)
    file = next(path for path in (tmp_path / "a" / "c").rglob("*") if path.is_file())
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(InputError, match="is cut short; a whole shard wanted"):
        Shards(array).read(np.empty((8, 8), F4), (0, 8), (0, 8))


def test_masks_take_a_bit_a_cell(tmp_path: Path) -> None:
    zarr.create_group(tmp_path)
    store, mask = GridStore(tmp_path, Blocks((50, 70), 20, Boundary("periodic"))), RANDOM.random((50, 70)) < 0.3
    store.add(MASK, mask.shape, bool)
    for block in range(len(store.blocks)):
        (r0, r1), (c0, c1) = area = store.blocks.area(block)
        store.write(MASK, area, mask[r0:r1, c0:c1])
    for block in range(len(store.blocks)):
        rows, cols, _ = store.blocks.around(block, 7)
        assert np.array_equal(store.read(MASK, rows, cols), mask[rows[:, None], cols])
    assert store.array(MASK).nbytes == 50 * 4 * 3  # of 20 cells three bytes


def test_a_zarr_array_as_state_and_input_is_not_copied_and_must_be_finite(tmp_path: Path) -> None:
    values = RANDOM.uniform(-1, 1, (256, 300)).astype(F4)
    array = zarr.create_array(tmp_path / "u.zarr", shape=values.shape, dtype=F4, chunks=(256, 300), compressors=None)
    array[...] = values
    wave = cnnsim.Template([[0.1, 0.2, 0.1], [0.2, 1.6, 0.2], [0.1, 0.2, 0.1]], 0.4, 0.05)
    task: dict[str, Any] = {"duration": 1.0, "dtype": "float32"}
    engine = Engine(workers=1, side=100, depth=4, store=tmp_path / "store")
    found = cnnsim.run_transient(wave, state=array, input=array, engine=engine, **task)
    assert found.x[...].tobytes() == cnnsim.run_transient(wave, state=values, input=values, **task).x.tobytes()
    assert not (tmp_path / "store" / "input").exists()
    again = cnnsim.run_transient(wave, state=found.x, input=array, engine=engine, store=tmp_path / "next", **task)
    dense = cnnsim.run_transient(wave, state=found.x[...], input=values, **task)
    assert again.x[...].tobytes() == dense.x.tobytes()
    array[3, 4] = np.nan
    with pytest.raises(InputError, match=r"block 0, from row 0, column 0: (state|input) holds what is not finite"):
        cnnsim.run_transient(wave, state=array, input=array, engine=engine, store=tmp_path / "other", **task)
