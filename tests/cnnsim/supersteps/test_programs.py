"""Programs on an engine: the bits of a run in memory, kept planes, Zarr arrays as inputs and outputs."""

from pathlib import Path
from typing import Any

import pytest

import cnnsim
from cnnsim import UniversalMachine, load_program
from cnnsim.supersteps.store import GridStore
from tests.kits.program import load
from tests.kits.stored_program import EVERYTHING, SHAPE, WAYS, assert_same, one, planes_of

zarr = pytest.importorskip("zarr")
NAMES = (
    "event-code", "gray-gradient", "life", "locate-strain", "maze-path", "motion-direction", "onset-wave",
    "texture-segmentation",
)  # fmt: skip
"""Programs with every kind of step; `python -m tests.benchmarks.scaling.programs` compares all that are shipped."""


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
    parts = UniversalMachine(engine=one(side=32))  # two blocks
    assert_same(parts.run(program, **planes), UniversalMachine().run(program, **planes))


def test_planes_without_a_later_use_are_deleted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    most, create, store = [0], GridStore.create, tmp_path / "store"

    def planes_in_store() -> int:
        return sum(path.name not in ("zarr.json", "outputs") for path in store.iterdir())

    def counted(grid: GridStore, *given: Any) -> Any:
        most[0] = max(most[0], planes_in_store())
        return create(grid, *given)

    monkeypatch.setattr(GridStore, "create", counted)
    program = load_program("texture-segmentation")
    planes = planes_of(program, (30, 37))
    found = cnnsim.run_program(program, engine=one(), store=store, **planes)
    assert 2 <= most[0] <= len(program.memory) + 2
    assert planes_in_store() == 0
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
    with pytest.warns(UserWarning, match="lies from 0 to 1"):  # gradients are not below 0
        again = cnnsim.run_program("opening", picture=found[next(iter(found))], engine=one(), store=tmp_path / "next")
        whole = cnnsim.run_program("opening", picture=next(iter(dense.values())))
    assert_same({name: plane[...] for name, plane in again.items()}, whole)
