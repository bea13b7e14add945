"""Programs on an engine that are stopped and resumed, and what is refused."""

import errno
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import UniversalMachine, load_program
from cnnsim.supersteps import stored_backend
from cnnsim.supersteps.plane_task import run_plane_task
from cnnsim.supersteps.store import GridStore
from cnnsim.support import Array, InputError
from tests.kits.program import load
from tests.kits.stored_program import EVERYTHING, SHAPE, WAYS, assert_same, drawn, one, planes_of

zarr = pytest.importorskip("zarr")


@pytest.mark.parametrize("name", ["everything", "motion-detection"])
def test_a_program_stopped_anywhere_resumes_to_the_same_bytes(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = load(tmp_path, EVERYTHING + WAYS) if name == "everything" else load_program(name)
    sequence = [planes_of(program, SHAPE) for _ in range(2)]
    dense = UniversalMachine()
    answers = [dense.run(program, **planes) for planes in sequence]
    left = [0]

    def full_disk(work: Any) -> Any:
        def limited(*given: Any) -> Any:
            left[0] -= 1
            if left[0] < 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return work(*given)

        return limited

    monkeypatch.setattr(GridStore, "create", full_disk(GridStore.create))
    monkeypatch.setattr(stored_backend, "run_plane_task", full_disk(run_plane_task))
    stops, found = 0, list[dict[str, Any]]()
    while len(found) < len(sequence):
        left[0] = 60 if name == "everything" else 25  # some operations further each time
        machine, found = UniversalMachine(engine=one(depth=6), store=tmp_path / "store"), []
        try:
            for planes in sequence:
                found.append(machine.run(program, **planes))
        except InputError as error:
            assert "No space left on device" in str(error)
            assert "store keeps the operations before: run again to resume" in str(error)
            stops += 1
    assert stops > 2
    for one_run, answer in zip(found, answers, strict=True):
        assert_same(one_run, answer)
    record = json.loads((tmp_path / "store" / "zarr.json").read_text())["attributes"]["record"]
    assert record["done"] > 20
    assert record["side"] == 24


def test_stores_of_something_else_are_refused(tmp_path: Path) -> None:
    picture, other, store = drawn(SHAPE), drawn(SHAPE), tmp_path / "store"
    machine = UniversalMachine(engine=one(), store=store)
    machine.run(load_program("opening"), picture=picture)
    machine.run(load_program("opening"), picture=other)

    def again(name: str, *pictures: Array, **choices: Any) -> None:
        fresh = UniversalMachine(**{"engine": one(side=None), "store": store, **choices})
        for one_picture in pictures:
            fresh.run(load_program(name), picture=one_picture)

    again("opening", picture, other)
    with pytest.raises(InputError, match="has the store of another run"):
        again("closing", picture)
    with pytest.raises(InputError, match="has the store of another run"):
        again("opening", picture, dtype="float64")
    with pytest.raises(InputError, match="has the store of another run"):
        again("opening", other)
    with pytest.raises(InputError, match=r"run 2 in .*store had other planes; the same planes"):
        again("opening", picture, picture)
    with pytest.raises(InputError, match="has blocks of side 24, not 32; side 24, or no side, wanted"):
        again("opening", picture, engine=one(side=32))
    with pytest.raises(InputError, match="another Zarr store, not one of cnnsim supersteps"):
        cnnsim.run_transient(cnnsim.Template(1.0), state=np.ones(SHAPE), duration=1.0, engine=one(), store=store)
    mark = json.loads((store / "zarr.json").read_text())
    mark["attributes"]["version"] = 2
    (store / "zarr.json").write_text(json.dumps(mark))
    with pytest.raises(InputError, match="store of version 2; version 5 wanted"):
        again("opening", picture)


def test_what_an_engine_cannot_do_is_refused_before_anything_runs(tmp_path: Path) -> None:
    text = EVERYTHING.replace('to = "c"\n', 'to = "c"\naccuracy = 1e-3\n', 1)
    with pytest.raises(InputError, match=r"step 2 .*accuracy with an engine"):
        UniversalMachine(engine=one(), store=tmp_path / "store").run(
            load(tmp_path, text), **planes_of(load(tmp_path, text), SHAPE)
        )
    assert not (tmp_path / "store").exists()
    with pytest.raises(InputError, match="holds values that are not finite"):
        UniversalMachine(engine=one()).run(load_program("opening"), picture=np.full(SHAPE, np.nan))
    bytes_ = zarr.create_array(tmp_path / "b.zarr", data=np.zeros(SHAPE, np.uint8))
    with pytest.raises(InputError, match="stored plane of uint8; CNN values as floats, or truth values, wanted"):
        cnnsim.run_program("opening", picture=bytes_, engine=one())
