"""Stores of transients: resumed after a stop, refused for another run; planes that are Zarr arrays."""

import errno
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim.network import Cell, Characteristic, LayeredTemplate, Template, Term
from cnnsim.network.characteristic import TANH
from cnnsim.supersteps import run
from cnnsim.supersteps.block_task import run_block
from cnnsim.supersteps.engine import Engine
from cnnsim.support import InputError
from tests.kits.supersteps import MIXED, SHAPE, U, X, one

PLANES: dict[str, Any] = {"state": X, "input": U}


def test_a_stopped_run_resumes_from_its_last_superstep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task: dict[str, Any] = {"state": X, "input": U, "duration": 3.0}
    whole = cnnsim.run_transient(MIXED, **task)
    done = [0]

    def full_disk(task: Any) -> Any:
        done[0] += 1
        if done[0] > 30:
            raise OSError(errno.ENOSPC, "No space left on device")
        return run_block(task)

    monkeypatch.setattr(run, "run_block", full_disk)
    engine = one(side=20, depth=5, store=tmp_path / "store")
    with pytest.raises(InputError, match=r"No space left on device; .*store keeps superstep 5, t = 2.5: run again"):
        cnnsim.run_transient(MIXED, engine=engine, **task)
    done[0] = -(10**6)
    again = cnnsim.run_transient(MIXED, engine=engine, **task)
    assert again.x.tobytes() == whole.x.tobytes()
    assert cnnsim.run_transient(MIXED, engine=engine, **task).x.tobytes() == whole.x.tobytes()  # has ended


def test_a_store_keeps_its_blocks_with_any_number_of_workers(tmp_path: Path) -> None:
    store = tmp_path / "store"
    task: dict[str, Any] = {"state": X, "input": U, "store": store}
    whole = cnnsim.run_transient(MIXED, engine=one(side=24), **task)
    for engine in (one(), Engine(workers=3), one(side=24)):
        again = cnnsim.run_transient(MIXED, engine=engine, **task)
        assert again.x.tobytes() == whole.x.tobytes()
        assert "blocks of 24 x 24" in again.plan.explain()
    with pytest.raises(InputError, match="store has blocks of side 24, not 20; side 24, or no side, wanted"):
        cnnsim.run_transient(MIXED, engine=one(side=20), **task)


def test_a_store_of_something_else_is_refused(tmp_path: Path) -> None:
    store = tmp_path / "store"
    task: dict[str, Any] = {"state": X, "input": U, "duration": 0.2, "engine": one(side=20, store=store)}
    cnnsim.run_transient(MIXED, **task)
    for change in ({"duration": 0.3}, {"state": U}, {"boundary": "periodic"}):
        with pytest.raises(InputError, match="has the store of another run"):
            cnnsim.run_transient(MIXED, **{**task, **change})
    mark = json.loads((store / "zarr.json").read_text())
    mark["attributes"]["version"] = 7
    (store / "zarr.json").write_text(json.dumps(mark))
    with pytest.raises(InputError, match="store of version 7; version 5 wanted"):
        cnnsim.run_transient(MIXED, **task)
    mark["attributes"] = {}
    (store / "zarr.json").write_text(json.dumps(mark))
    with pytest.raises(InputError, match="another Zarr store"):
        cnnsim.run_transient(MIXED, **task)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty and has no store"):
        cnnsim.run_transient(MIXED, **{**task, "engine": one(store=tmp_path / "other")})


def test_the_store_of_another_characteristic_is_refused(tmp_path: Path) -> None:
    task: dict[str, Any] = {"state": X, "input": U, "duration": 0.2, "step": 0.1, "engine": one(side=20, depth=1)}
    cnnsim.run_transient(MIXED, cell=Cell("chua-yang", TANH), store=tmp_path / "store", **task)
    for slope in (0.5, 3):
        with pytest.raises(InputError, match="has the store of another run"):
            cell = Cell("chua-yang", Characteristic(slope=slope))
            cnnsim.run_transient(MIXED, cell=cell, store=tmp_path / "store", **task)


@pytest.mark.parametrize("time", [0.0, 0.2])
def test_the_result_of_a_run_that_has_ended_is_read_from_its_store(tmp_path: Path, time: float) -> None:
    task: dict[str, Any] = {"state": X, "input": U, "duration": time, "boundary": "periodic"}
    whole = cnnsim.run_transient(MIXED, **task)
    for _ in range(2):
        again = cnnsim.run_transient(MIXED, engine=one(side=20), store=tmp_path / "store", **task)
        assert again.x.tobytes() == whole.x.tobytes()
        assert again.t == time


def test_transients_that_need_the_whole_grid_are_refused() -> None:
    delayed = Template(1.0, terms=[Term([[0.1]], "y_kl", delay=0.5)])
    with pytest.raises(InputError, match="has delays; a template without, or no engine, wanted"):
        cnnsim.run_transient(delayed, state=X, duration=1.0, engine=one())
    for output in (Characteristic(slope=3), Characteristic(slope=0.5), TANH):  # each changes its own result
        with pytest.raises(InputError, match=f"the characteristic {output}; sign, or clip of slope 1, wanted"):
            cnnsim.run_transient(MIXED, state=X, input=U, cell=Cell("discrete-time", output), duration=2, engine=one())
    with pytest.raises(InputError, match="accuracy with an engine"):
        cnnsim.run_transient(MIXED, state=X, input=U, accuracy=1e-3, engine=one())
    with pytest.raises(InputError, match="engine 'spark'; processes or dask=ADDRESS wanted"):
        cnnsim.run_transient(MIXED, state=X, input=U, engine="spark")


def test_planes_may_be_zarr_arrays_and_so_is_the_result_then(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    state = zarr.create_array(tmp_path / "x.zarr", shape=SHAPE, chunks=(16, 16), dtype="f4")
    state[...] = X
    whole = cnnsim.run_transient(MIXED, state=X.astype(np.float32), input=U, duration=1.0)
    found = cnnsim.run_transient(
        MIXED, state=state, input=U, duration=1.0, engine=one(side=20), store=tmp_path / "store"
    )
    assert type(found.x).__module__.startswith("zarr")
    assert found.x[...].tobytes() == whole.x.tobytes()
    assert found.y.tobytes() == whole.y.tobytes()


def test_a_stored_plane_of_one_layer_stands_for_all(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    layers = LayeredTemplate([MIXED, Template([[0.5]], terms=[Term([[0.3]], "y_kl", layer=0)])])
    planes: dict[str, Any] = {"state": np.stack([X, U]), "input": np.stack([U, X]), "bias": 0.1 * X, "mask": U > 0.8}
    task: dict[str, Any] = {"duration": 1.0, "dtype": "float64"}
    whole = cnnsim.run_transient(layers, **planes, **task)
    stored: dict[str, Any] = {
        name: zarr.create_array(tmp_path / name, data=plane, chunks=(2, 16, 16)[3 - plane.ndim :])
        for name, plane in planes.items()
    }
    found = cnnsim.run_transient(layers, **stored, **task, engine=one(side=20, depth=5, store=tmp_path / "store"))
    assert np.array_equal(np.asarray(found.x[...]), whole.x)
    assert "on the disk" in repr(found)
    assert "on the disk" in found._repr_html_()


def test_stored_planes_have_the_meaning_of_arrays(tmp_path: Path) -> None:
    """Booleans are black and white; whole numbers are refused."""
    zarr = pytest.importorskip("zarr")
    task: dict[str, Any] = {"state": X, "duration": 1.0}
    black = zarr.create_array(tmp_path / "black.zarr", data=U > 0, chunks=SHAPE)
    levels = zarr.create_array(tmp_path / "levels.zarr", data=np.zeros(SHAPE, np.int64), chunks=SHAPE)
    whole = cnnsim.run_transient(MIXED, **task, input=U > 0)
    assert np.array_equal(cnnsim.run_transient(MIXED, **task, input=black, engine=one()).x, whole.x)
    for name in ("state", "input", "bias"):
        with pytest.raises(InputError, match=f"{name} is a stored plane of int64; CNN values as floats, or truth"):
            cnnsim.run_transient(MIXED, **{"input": U, **task, name: levels}, engine=one())


def test_a_stored_plane_with_other_values_belongs_to_another_run(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    planes: dict[str, Any] = {
        name: zarr.create_array(tmp_path / name, data=plane, chunks=(16, 16)) for name, plane in PLANES.items()
    }
    task: dict[str, Any] = {"duration": 0.2, "dtype": "float64"}
    whole = cnnsim.run_transient(MIXED, **PLANES, **task).x
    for _ in range(2):
        found = cnnsim.run_transient(MIXED, **planes, **task, engine=one(side=20), store=tmp_path / "store")
        assert found.x[...].tobytes() == whole.tobytes()
    for plane in planes.values():
        value = float(plane[3, 4])
        plane[3, 4] = value + 0.5
        with pytest.raises(InputError, match="has the store of another run"):
            cnnsim.run_transient(MIXED, **planes, **task, engine=one(side=20), store=tmp_path / "store")
        plane[3, 4] = value


@pytest.mark.parametrize("grey", [False, True])
def test_a_stored_state_is_planned_like_one_in_memory(grey: bool, tmp_path: Path) -> None:
    """Waves that grow as they travel need rk4 if the state is grey."""
    zarr = pytest.importorskip("zarr")
    x = X if grey else np.sign(X)
    state = zarr.create_array(tmp_path / "x.zarr", data=x, chunks=(16, 16))
    template = cnnsim.Template([[0, 0, 0], [1, 2, 2], [0, 0, 0]])
    task: dict[str, Any] = {"duration": 2.0, "dtype": "float64"}
    whole = cnnsim.run_transient(template, state=x, **task)
    found = cnnsim.run_transient(template, state=state, engine=one(side=20), store=tmp_path / "store", **task)
    for result in (whole, found):
        assert result.plan.scheme is not None
        assert result.plan.scheme.name == ("rk4" if grey else "euler")
    assert np.asarray(found.x[...]).tobytes() == whole.x.tobytes()
