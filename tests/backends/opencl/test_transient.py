"""Transients of the OpenCL backend: several steps a launch, shared sums, local memory, sleep."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyopencl as cl
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed, library
from cnnsim.backends import get, slices
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
def test_blocks_of_three_rows_give_the_bits_of_blocks_of_one(boundary: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from cnnsim.backends.opencl import tiles

    backend, rng = OpenCLBackend("float32"), np.random.default_rng(4)
    for shape in (1, 1), (2, 3), (5, 31), (2, 7, 16), (4, 9), (62, 30):
        x, mask = rng.uniform(-1, 1, shape), rng.uniform(-1, 0.3, shape)
        task = make_task(Template(NINE), state=x, mask=mask, boundary=boundary, duration=3.0, scheme="euler", step=0.1)
        ends = []
        for few in tiles.FEW_CELLS, 0:
            monkeypatch.setattr(tiles, "FEW_CELLS", few)
            ends.append(backend.read(task.start(backend).x))
        monkeypatch.undo()
        assert np.array_equal(ends[0], ends[1]), shape


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", BOUNDARIES[:3], ids=str)
def test_a_boundary_that_tiles_do_not_know_goes_by_stages(
    boundary: Any, family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cnnsim.backends.opencl import transient

    backend, rng = OpenCLBackend("float64", family=family), np.random.default_rng(2)
    task = make_task(
        Template(NINE), state=rng.uniform(-1, 1, (2, 9, 11)), mask=rng.uniform(-1, 0.3, (2, 9, 11)),
        boundary=boundary, duration="settled", limit=4.0, scheme="euler",
    )  # fmt: skip
    tiled = task.start(backend)
    monkeypatch.setattr(transient, "TILED_BOUNDARIES", ())
    staged = task.start(backend)
    assert tiled[1:3] == staged[1:3]
    assert np.array_equal(backend.read(tiled.x), backend.read(staged.x))


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
    """One by one, as those of 8192 x 8192 cells were once, each would go through all of the memory."""
    for name, value in {"FIRST": 1, "SLICE": 1e-9, "PIECE": 1e6}.items():
        monkeypatch.setattr(slices, name, value)
    from cnnsim.backends.opencl import transient
    from cnnsim.backends.opencl.context import DeviceContext

    asked, counts = list[int](), list[int]()
    steps, waits, launches = transient._TileSteps.advance, DeviceContext.pieces, DeviceContext.enqueue

    def advance(self: Any, step: int, count: int) -> None:
        asked.append(count)
        steps(self, step, count)

    def pieces(self: Any, count: int, work: float) -> Any:
        found = list(waits(self, count, work))
        counts.append(len(found))
        return iter(found)

    def enqueue(self: Any, kernel: Any, *shape: Any) -> None:
        assert len(shape) == 2, "PoCL compiles a kernel once more for an offset"
        launches(self, kernel, *shape)

    monkeypatch.setattr(transient._TileSteps, "advance", advance)
    monkeypatch.setattr(DeviceContext, "pieces", pieces)
    monkeypatch.setattr(DeviceContext, "enqueue", enqueue)
    rng = np.random.default_rng(2)  # what is compiled for the test of the same bits
    x, mask = rng.uniform(-1, 1, (70, 1100)), rng.uniform(-1, 0.3, (70, 1100))
    given: Any = {"state": x, "mask": mask, "boundary": BOUNDARIES[0], "duration": 3.7, "scheme": "euler"}
    task = make_task(Template(NINE), **given)
    task.start(OpenCLBackend("float32", family="cpu"))
    assert asked == [-(-task.plan.steps // 2), task.plan.steps // 2]
    assert max(counts) > 1, "a stop is heard between pieces"


def test_launches_are_of_equal_length_and_tiles_of_bounded_work() -> None:
    """A short last launch goes through memory as a long one does; a stop is heard when a core has done its tile."""
    from cnnsim.backends.opencl.planes import DeviceGrid
    from cnnsim.backends.opencl.tiles import cut

    context: Any = SimpleNamespace(
        family="cpu", lanes=8, dtype=np.dtype("float32"), cores=2, device=SimpleNamespace(local_mem_size=1 << 21)
    )
    shape = (1, 16384, 16384)
    plan = make_plan(Template(NINE), shape, ZERO_FLUX, duration=10.0, scheme="euler", step=0.1)
    tiles = cut(context, DeviceGrid(*shape), plan)
    assert (tiles.steps, tiles.defines["T"]) == (20, 24)  # one kernel for all durations
    assert 9 * 24 * 16384**2 / tiles.groups <= 1.1 * slices.PIECE


@pytest.mark.parametrize("limit", [32 * 1024, 512 * 1024, 1024 * 1024])
def test_tiles_fit_into_the_local_memory_there_is(limit: int) -> None:
    """A device that is given more than it has writes over whatever lies behind."""
    from cnnsim.backends.opencl.planes import DeviceGrid
    from cnnsim.backends.opencl.tiles import cut

    context: Any = SimpleNamespace(
        family="cpu", lanes=16, dtype=np.dtype("float64"), cores=2, device=SimpleNamespace(local_mem_size=limit)
    )
    for radius, shape in ((1, (1, 2048, 2048)), (1, (3, 40, 300)), (5, (1, 512, 512))):
        side = 2 * radius + 1
        plan = make_plan(Template(np.ones((side, side)) / side**2), shape, ZERO_FLUX, duration=100.0)
        tiles = cut(context, DeviceGrid(*shape), plan)
        assert tiles.arguments[0].size <= limit
        assert 1 <= tiles.steps <= 24


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("name", ["hole-filler", "connected-components-horizontal"])
def test_sleeping_tiles_wake_up_where_a_wave_comes(name: str, boundary: Any, family: Family) -> None:
    """Two grids at once, three tiles beside each other, the last of them narrow; one grid settles much earlier."""
    picture = np.where(np.random.default_rng(8).random((2, 150, 265)) > 0.93, 1.0, -1.0)
    picture[0, 40:110, [60, 160]] = picture[0, [40, 110], 60:160] = 1
    picture[1, :, 20:] = -1
    entry, backend = library.load(name), OpenCLBackend("float32", family=family)
    planes: dict[str, Any] = {
        name: np.broadcast_to(plane, picture.shape) for name, plane in entry.planes(picture).items()
    }
    ends = []
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, boundary=boundary, limit=300.0, without=without).start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])


@pytest.mark.parametrize("family", FAMILIES)
def test_masked_tiles_that_read_far_sleep_and_wake_up(family: Family) -> None:
    """A wave that begins in a corner of a torus and goes two cells at a time; the last tiles are narrow."""
    A, rng, shape = np.zeros((5, 5)), np.random.default_rng(5), (2, 109, 141)
    A[2, 2], A[[0, 2, 2, 4], [2, 0, 4, 2]] = 3, 1
    x = np.ones(shape)
    x[0, :4, :4] = -1
    given: Any = {
        "state": x, "input": np.where(rng.random(shape) > 0.9, 1.0, -1.0), "mask": rng.uniform(-1, 0.05, shape),
        "boundary": PERIODIC, "scheme": "euler", "limit": 300.0,
    }  # fmt: skip
    ends, backend = [], OpenCLBackend("float64", family=family)
    for without in ([], ["sleep"]):
        task = make_task(Template(A, [[4.0]], -1.0), **given, without=without)
        assert ("sleep" in task.plan.savings) == (not without)
        end = task.start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])
    assert ends[0][2] and np.mean(ends[0][0][0] < 0) > 0.2


@pytest.mark.parametrize("family", FAMILIES)
def test_a_tile_coasts_while_no_output_in_it_can_change_and_then_sleeps(
    family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cnnsim.backends.opencl import transient

    entry, backend, seen = library.load("hole-filler"), OpenCLBackend("float32", family=family), list[Any]()
    steps = transient._TileSteps.advance

    def advance(self: Any, step: int, count: int) -> None:
        steps(self, step, count)
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[self._turn - 1])
        seen.append(found)

    monkeypatch.setattr(transient._TileSteps, "advance", advance)
    picture = np.full((2, 150, 265), -1.0)
    picture[0] = 1  # nothing can change in this grid, and in the other a wave goes through all
    planes: dict[str, Any] = {k: np.broadcast_to(plane, picture.shape) for k, plane in entry.planes(picture).items()}
    make_task(entry.template, **planes, boundary=fixed(-1.0), limit=40.0).start(backend)
    flags = np.array(seen).reshape(len(seen), 2, -1)
    assert (flags[:, 0] <= 1).all() and (flags[:5, 0] == 1).all(), "it coasts: its states still change"
    assert (flags[-1, 0] == 0).all(), "it sleeps"
    assert (flags[-1, 1] > 1).any(), "the other one is awake"


@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
def test_tiles_are_cut_smaller_and_larger_again_and_launched_ahead_with_the_same_bits(
    boundary: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At every other look, with a mask; the stacks of the smaller tiles are not all full, the last ones are narrow."""
    from cnnsim.backends.opencl import transient
    from cnnsim.backends.opencl.tiles import cut

    changes, ahead, go_ahead = list[bool](), set[int](), transient._TileSteps.go_ahead

    def noted(*given: Any, light: bool) -> Any:
        changes.append(light)
        return cut(*given, light=light)

    def gone(self: Any) -> None:
        go_ahead(self)
        ahead.add(self._ahead)

    monkeypatch.setattr(transient, "cut", noted)
    monkeypatch.setattr(transient._TileSteps, "go_ahead", gone)
    for name, value in {"LOOK": 4, "MANY": 3, "FEW_RESTLESS": 2.0, "MOST_RESTLESS": -1.0}.items():
        monkeypatch.setattr(transient, name, value)
    entry, backend, rng = library.load("hole-filler"), OpenCLBackend("float32", family="cpu"), np.random.default_rng(8)
    picture = np.where(rng.random((2, 150, 265)) > 0.93, 1.0, -1.0)
    planes: dict[str, Any] = {k: np.array(np.broadcast_to(p, picture.shape)) for k, p in entry.planes(picture).items()}
    planes["state"][:, :6, :6] = -1  # where a wave begins, also with nothing around the grid
    mask, ends = rng.uniform(-1, 0.01, picture.shape), []
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, mask=mask, boundary=boundary, limit=60.0, without=without)
        x, *others = end.start(backend)
        ends.append((backend.read(x), others))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1], ends[1][1])
    assert changes[:4] == [False, True, False, True]
    assert ahead == {0, 5, 10}, "it is not waited for what a check says"


def test_by_name_and_by_way_of_run_transient() -> None:
    x = np.random.default_rng(9).uniform(-1, 1, (20, 20))
    ours = run_transient(Template(NINE), state=x, duration=2.0, backend="opencl", dtype="float64")
    assert np.array_equal(ours.x, run_transient(Template(NINE), state=x, duration=2.0, backend="reference").x)
    with pytest.raises(InputError, match="the adaptive scheme runs on the reference backend"):
        run_transient(Template(NINE), state=x, duration=2.0, scheme="adaptive", backend="opencl")


@pytest.mark.parametrize("family", FAMILIES)
def test_stages_have_the_bits_of_the_reference(family: Family) -> None:
    """In float64, of free cells and of those that a mask holds, at the rim and inside."""
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
