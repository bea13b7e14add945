"""Transients of linear templates on OpenCL: several steps a launch, shared sums, local memory."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed
from cnnsim.backends import slices
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


def test_shared_sums_stay_within_the_rounding_of_one_sum_a_step() -> None:
    task = [
        make_task(Template([[0.1, 0.2, 0.1], [0.2, 0.3, 0.2], [0.1, 0.2, 0.1]]), state=x, duration=5.0, without=w)
        for x in [np.random.default_rng(3).uniform(-1, 1, (40, 50))]
        for w in ([], ["shared sums"])
    ]
    backend = OpenCLBackend("float32", family="cpu")
    shared, plain = (backend.read(t.start(backend).x) for t in task)
    assert 0 < np.abs(shared - plain).max() < 50 * 1.5 * np.finfo(np.float32).eps


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
