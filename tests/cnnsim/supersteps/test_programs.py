"""Whole programs on planes that lie on the disk: the dense machine's bits, what is kept, and what a stop leaves."""

import errno
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import UniversalMachine, load_program
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.shards import Shards
from cnnsim.support import Array, InputError
from tests.kits.program import load

zarr = pytest.importorskip("zarr")
RANDOM = np.random.default_rng(4)
SHAPE = (40, 44)
NAMES = (
    "event-code", "gray-gradient", "life", "locate-strain", "maze-path", "motion-direction", "onset-wave",
    "texture-segmentation",
)  # fmt: skip
"""Programs with every kind of step; `python -m tests.benchmarks.scaling.programs` compares all that are shipped."""


def one(**choices: Any) -> Engine:
    return Engine(workers=1, **{"side": 24, **choices})


def drawn(shape: tuple[int, ...]) -> Array:
    found = RANDOM.random(shape) < 0.5
    found[..., 2:9, 3 : shape[-1] - 2] = True
    found[..., 4:7, 5:9] = False
    return found


def planes_of(program: cnnsim.Program, shape: tuple[int, ...]) -> dict[str, Any]:
    grey = RANDOM.integers(-64, 65, (len(program.inputs), *shape)) / 64
    return {
        name: drawn(shape) if program.memory[name] == "llm" else grey[number]
        for number, name in enumerate(program.inputs)
    }


def assert_same(found: dict[str, Any], dense: dict[str, Any]) -> None:
    assert found.keys() == dense.keys()
    for name, value in dense.items():
        assert np.asarray(found[name]).dtype == np.asarray(value).dtype, name
        assert np.asarray(found[name]).tobytes() == np.asarray(value).tobytes(), name


@pytest.mark.parametrize("name", NAMES)
def test_shipped_programs_give_the_dense_bits(name: str) -> None:
    program = load_program(name)
    dtype: Any = ("float32", "float64")[len(name) % 2]
    planes = planes_of(program, (30, 37))
    found = cnnsim.run_program(program, dtype=dtype, engine=one(), **planes)
    assert_same(found, cnnsim.run_program(program, dtype=dtype, **planes))


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_another_backend_gives_its_own_bits(dtype: Any) -> None:
    pytest.importorskip("pyopencl")
    program = load_program("onset-wave")
    planes = planes_of(program, (48, 48))  # blocks of one shape: kernels are built for each
    dense = cnnsim.run_program(program, backend="opencl", dtype=dtype, **planes)
    assert_same(cnnsim.run_program(program, backend="opencl", dtype=dtype, engine=one(), **planes), dense)


EVERYTHING = """
name = "everything"
lam = ["a", "b", "c"]
llm = ["p", "q", "r", "old"]
wire = ["n", "m", "k"]
inputs = ["a", "p"]
outputs = ["c", "r", "b", "q", "n", "m", "k"]
keep = { old = -1 }
[parameters]
times = 3
[templates.spread]
A = [[0, 0.4, 0], [0.4, 1.2, 0.4], [0, 0.4, 0]]
B = [[0, 0, 0], [0.1, 0.5, 0], [0, 0, 0]]
z = 0.1
boundary = "periodic"
duration = 1.3
[templates.grey]
A = [[0, 0.2, 0], [0.2, 0.1, 0.2], [0, 0.2, 0]]
B = 0.3
boundary = { fixed = 0.25 }
[[step]]
template = "spread"
input = "p"
state = "a"
bias = "a"
mask = "p"
to = "b"
[[step]]
template = "grey"
input = "b"
state = 0.5
to = "c"
[[step]]
copy = "c"
to = "q"
[[step]]
fill = 0.3
to = "a"
[[step]]
cellwise = "add"
of = ["a", "c"]
to = ["c"]
[[step]]
template = "dilation-cross"
input = "q"
boundary = "periodic"
to = "r"
[[step]]
logic = "xor"
of = ["r", "old"]
to = "r"
[[step]]
wire = "count"
of = "r"
to = "n"
[[step]]
wire = "any"
of = "r"
to = "m"
[[step]]
wire = "all"
of = "r"
to = "k"
[[step]]
repeat = "times"
[[step.do]]
number = "add"
of = ["n", 1]
to = "n"
[[step.do]]
template = "erosion-cross"
input = "r"
to = "r"
[[step]]
copy = "r"
to = "old"
"""
WAYS = """
[[step]]
when = "m"
[[step.do]]
until_unchanged = "r"
[[step.do.do]]
template = "erosion-cross"
input = "r"
to = "r"
[[step.otherwise]]
fill = 1
to = "r"
"""


def test_every_kind_of_step_and_kept_planes_over_runs(tmp_path: Path) -> None:
    program = load(tmp_path, EVERYTHING + WAYS)
    dense, parts = UniversalMachine(), UniversalMachine(engine=one(depth=5))
    for _ in range(2):
        planes = planes_of(program, SHAPE)
        assert_same(parts.run(program, **planes), dense.run(program, **planes))
        assert_same(parts.kept(program), dense.kept(program))


def test_grids_of_a_batch_have_a_wire_each(tmp_path: Path) -> None:
    program = load(tmp_path, EVERYTHING + '[[step]]\nfill = "n"\nto = "b"\n')
    planes = planes_of(program, (2, 30, 37))
    planes["p"][0] = True
    assert_same(UniversalMachine(engine=one()).run(program, **planes), UniversalMachine().run(program, **planes))


def files(store: Path) -> int:
    return sum(path.name not in ("zarr.json", "outputs") for path in store.iterdir())


def test_planes_that_nobody_needs_go_and_black_and_white_takes_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    most, write = [0], Shards.write

    def counted(shards: Shards, *given: Any) -> None:
        write(shards, *given)
        most[0] = max(most[0], files(tmp_path / "store"))

    monkeypatch.setattr(Shards, "write", counted)
    program = load_program("texture-segmentation")
    planes = planes_of(program, (30, 37))
    found = cnnsim.run_program(program, engine=one(), store=tmp_path / "store", **planes)
    assert 2 <= most[0] <= len(program.memory) + 2
    assert files(tmp_path / "store") == 0  # results alone are left
    assert_same(found, cnnsim.run_program(program, **planes))


def test_zarr_in_zarr_out(tmp_path: Path) -> None:
    program = load_program("gray-gradient")
    planes = {name: plane.astype("f4") for name, plane in planes_of(program, SHAPE).items()}
    group = zarr.open_group(tmp_path / "given.zarr")
    given = {name: group.create_array(name, data=plane, chunks=(20, 64)) for name, plane in planes.items()}
    found = cnnsim.run_program(program, engine=one(), store=tmp_path / "store", **given)
    dense = cnnsim.run_program(program, **planes)
    for name, value in dense.items():
        assert type(found[name]).__module__.startswith("zarr")
        assert zarr.open_array(tmp_path / "store" / "outputs" / name, mode="r")[...].tobytes() == value.tobytes()
    again = cnnsim.run_program("opening", picture=found[next(iter(found))], engine=one(), store=tmp_path / "next")
    whole = cnnsim.run_program("opening", picture=next(iter(dense.values())))
    assert_same({name: plane[...] for name, plane in again.items()}, whole)


@pytest.mark.parametrize("name", ["everything", "motion-detection"])
def test_a_program_that_was_stopped_anywhere_goes_on_to_the_same_bytes(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = load(tmp_path, EVERYTHING + WAYS) if name == "everything" else load_program(name)
    sequence = [planes_of(program, SHAPE) for _ in range(2)]
    dense = UniversalMachine()
    answers = [dense.run(program, **planes) for planes in sequence]
    left, write = [0], Shards.write

    def full_disk(shards: Shards, *given: Any) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(shards, *given)

    monkeypatch.setattr(Shards, "write", full_disk)
    stops, found = 0, list[dict[str, Any]]()
    while len(found) < len(sequence):
        left[0] = 60 if name == "everything" else 25  # some operations further each time
        machine, found = UniversalMachine(engine=one(depth=6), store=tmp_path / "store"), []
        try:
            for planes in sequence:
                found.append(machine.run(program, **planes))
        except InputError as error:
            assert "No space left on device" in str(error)
            assert "store keeps what was done before: run again to go on" in str(error)
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
    with pytest.raises(InputError, match=r"run 2 in .*store was of other planes"):
        again("opening", picture, picture)
    with pytest.raises(InputError, match="has blocks of 24 cells; 32 wanted, elsewhere"):
        again("opening", picture, engine=one(side=32))
    with pytest.raises(InputError, match="another Zarr store, not one of cnnsim supersteps"):
        cnnsim.run_transient(cnnsim.Template(1.0), state=np.ones(SHAPE), duration=1.0, engine=one(), store=store)
    mark = json.loads((store / "zarr.json").read_text())
    mark["attributes"]["version"] = 2
    (store / "zarr.json").write_text(json.dumps(mark))
    with pytest.raises(InputError, match="store of version 2; version 3 wanted"):
        again("opening", picture)


def test_what_an_engine_cannot_do_is_told_before_anything_runs(tmp_path: Path) -> None:
    text = EVERYTHING.replace('to = "c"\n', 'to = "c"\naccuracy = 1e-3\n', 1)
    with pytest.raises(InputError, match=r"step 2 .*an accuracy on an engine"):
        UniversalMachine(engine=one(), store=tmp_path / "store").run(
            load(tmp_path, text), **planes_of(load(tmp_path, text), SHAPE)
        )
    assert not (tmp_path / "store").exists()
    with pytest.raises(InputError, match="holds what is not finite"):
        UniversalMachine(engine=one()).run(load_program("opening"), picture=np.full(SHAPE, np.nan))
    bytes_ = zarr.create_array(tmp_path / "b.zarr", data=np.zeros(SHAPE, np.uint8))
    with pytest.raises(InputError, match="stored plane of uint8; CNN values as floats, or truth values, wanted"):
        cnnsim.run_program("opening", picture=bytes_, engine=one())
