"""Transients of linear templates on OpenCL: several steps a launch, shared sums, local memory."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed
from cnnsim.backends import get, slices
from cnnsim.backends.opencl import tiles as opencl_tiles
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.opencl.linear_steps import DeviceLinearSteps
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.tiles import cut
from cnnsim.planning.plan import make_plan
from cnnsim.task import make_task
from cnnsim.transient import run_transient
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])


BOUNDARIES = [ZERO_FLUX, PERIODIC, fixed(0.5, -0.3), fixed(-1.0)]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", BOUNDARIES[:3], ids=str)
def test_many_steps_a_launch_give_the_same_bits(boundary: Any, family: Family) -> None:
    backend = OpenCLBackend("float64" if boundary is PERIODIC else "float32", family=family)
    rng = np.random.default_rng(2)
    for template, shape in ((Template(NINE), (70, 1100)), (Template(rng.normal(size=(5, 5)) / 5), (2, 40, 30))):
        x, mask = rng.uniform(-1, 1, shape), rng.uniform(-1, 0.3, shape)
        given: Any = {"state": x, "mask": mask, "boundary": boundary, "duration": 3.7, "scheme": "euler"}
        one, many = (make_task(template, **given, without=w).start(backend).x for w in (["blocking"], []))
        assert np.array_equal(backend.read(one), backend.read(many))


@pytest.mark.parametrize("boundary", BOUNDARIES[:3], ids=str)
def test_rows_that_are_moved_up_often_end_as_on_the_reference(boundary: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tiles so narrow, in so little memory, that rows stream through it many times; in float64 the same bits."""
    rng, wide = np.random.default_rng(6), np.random.default_rng(7).normal(size=(5, 5)) / 10
    for name, value in {"ROW_BYTES": 256, "SCRATCH": 1 << 16}.items():
        monkeypatch.setattr(opencl_tiles, name, value)
    for A in NINE, wide, [[0.1, 0.2, 0.1], [0.2, 0.3, 0.2], [0.1, 0.2, 0.1]]:
        x = rng.uniform(-1.5, 1.5, (2, 301, 150))
        task = make_task(Template(A), state=x, boundary=boundary, duration=3.0, scheme="euler", step=0.1)
        right = get("reference").read(task.start(get("reference")).x)
        for dtype, most in ("float64", 0.0), ("float32", 30 * np.finfo(np.float32).eps):  # a rounding a step
            backend = OpenCLBackend(dtype, family="cpu")
            assert np.abs(backend.read(task.start(backend).x) - right).max() <= most


def test_shared_sums_stay_within_the_rounding_of_one_sum_a_step() -> None:
    task = [
        make_task(Template([[0.1, 0.2, 0.1], [0.2, 0.3, 0.2], [0.1, 0.2, 0.1]]), state=x, duration=5.0, without=w)
        for x in [np.random.default_rng(3).uniform(-1, 1, (40, 50))]
        for w in ([], ["shared sums"])
    ]
    backend = OpenCLBackend("float32", family="cpu")
    shared, plain = (backend.read(t.start(backend).x) for t in task)
    assert 0 < np.abs(shared - plain).max() < 50 * 1.5 * np.finfo(np.float32).eps


def test_steps_stay_together_however_long_they_take(monkeypatch: pytest.MonkeyPatch) -> None:
    """One by one, each would go through all of the memory."""
    for name, value in {"FIRST": 1, "SLICE": 1e-9, "PIECE": 1e6}.items():
        monkeypatch.setattr(slices, name, value)
    asked, counts = list[int](), list[int]()
    steps, waits = DeviceLinearSteps.advance, DeviceContext.pieces

    def advance(self: Any, step: int, count: int) -> None:
        asked.append(count)
        steps(self, step, count)

    def pieces(self: Any, count: int, work: float) -> Any:
        found = list(waits(self, count, work))
        counts.append(len(found))
        return iter(found)

    monkeypatch.setattr(DeviceLinearSteps, "advance", advance)
    monkeypatch.setattr(DeviceContext, "pieces", pieces)
    rng = np.random.default_rng(2)  # the same kernel as in the test of the same bits
    x, mask = rng.uniform(-1, 1, (70, 1100)), rng.uniform(-1, 0.3, (70, 1100))
    given: Any = {"state": x, "mask": mask, "boundary": BOUNDARIES[0], "duration": 3.7, "scheme": "euler"}
    task = make_task(Template(NINE), **given)
    task.start(OpenCLBackend("float32", family="cpu"))
    assert asked == [-(-task.plan.steps // 2), task.plan.steps // 2]
    assert max(counts) > 1, "an interrupt is handled between pieces"


def test_launches_are_of_equal_length_and_tiles_of_bounded_work() -> None:
    """A short last launch goes through memory as a long one does; an interrupt waits until a core has done its tile."""
    context: Any = SimpleNamespace(
        family="cpu", lanes=8, dtype=np.dtype("float32"), cores=2, device=SimpleNamespace(local_mem_size=1 << 21)
    )
    shape = (1, 16384, 16384)
    plan = make_plan(Template(NINE), shape, ZERO_FLUX, duration=10.0, scheme="euler", step=0.1)
    tiles = cut(context, DeviceGrid(*shape), plan)
    assert (tiles.steps, tiles.defines["T"]) == (20, 24)  # one kernel for all durations
    assert 9 * 24 * 16384**2 / tiles.number <= 1.1 * slices.PIECE


@pytest.mark.parametrize("limit", [32 * 1024, 512 * 1024, 1024 * 1024])
def test_tiles_fit_into_the_local_memory_there_is(limit: int) -> None:
    """A kernel with more local memory than the device has would overwrite other memory."""
    context: Any = SimpleNamespace(
        family="cpu", lanes=16, dtype=np.dtype("float64"), cores=2, device=SimpleNamespace(local_mem_size=limit)
    )
    for radius, shape in ((1, (1, 2048, 2048)), (1, (3, 40, 300)), (5, (1, 512, 512))):
        side = 2 * radius + 1
        plan = make_plan(Template(np.ones((side, side)) / side**2), shape, ZERO_FLUX, duration=100.0)
        tiles = cut(context, DeviceGrid(*shape), plan)
        assert tiles.arguments[0].size <= limit
        assert 1 <= tiles.steps <= 24


def test_by_name_and_by_way_of_run_transient() -> None:
    x = np.random.default_rng(9).uniform(-1, 1, (20, 20))
    ours = run_transient(Template(NINE), state=x, duration=2.0, backend="opencl", dtype="float64")
    assert np.array_equal(ours.x, run_transient(Template(NINE), state=x, duration=2.0, backend="reference").x)
    with pytest.raises(InputError, match="the adaptive scheme runs on the reference backend"):
        run_transient(Template(NINE), state=x, duration=2.0, scheme="adaptive", backend="opencl")


@pytest.mark.parametrize("family", FAMILIES)
def test_stages_have_the_bits_of_the_reference(family: Family) -> None:
    """In float64, in free and masked cells, at the rim and inside."""
    backend, reference = OpenCLBackend("float64", family=family), get("reference")
    rng = np.random.default_rng(5)
    x, mask = rng.uniform(-1, 1, (23, 66)), rng.random((23, 66)) - 0.7
    for number, (scheme, cell) in enumerate(itertools.product(("heun", "rk4"), ("chua-yang", "full-range"))):
        choices: Any = {
            "scheme": scheme,
            "step": 0.1,
            "cell": cell,
            "duration": 0.7,
            "boundary": BOUNDARIES[number % 3],
        }
        for held in (None, mask):
            task = make_task(Template(NINE), state=x, mask=held, **choices)
            found, wanted = (where.read(task.start(where).x) for where in (backend, reference))
            np.testing.assert_array_equal(found, wanted)
