"""Sleeping tiles of the OpenCL backend on a CPU: the same bits as without, and left out where nothing changes."""

from typing import Any

import numpy as np
import pyopencl as cl
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
from cnnsim.backends.opencl.linear_steps import DeviceLinearSteps
from cnnsim.task import make_task
from tests.kits.opencl import OpenCLBackend


@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("name", ["hole-filler", "connected-components-horizontal"])
def test_sleeping_tiles_wake_up_where_a_wave_comes(name: str, boundary: Any) -> None:
    """Two grids at once, three tiles next to each other, the last of them narrow; one grid settles much earlier."""
    picture = np.where(np.random.default_rng(8).random((2, 150, 265)) > 0.93, 1.0, -1.0)
    picture[0, 40:110, [60, 160]] = picture[0, [40, 110], 60:160] = 1
    picture[1, :, 20:] = -1
    entry, backend = library.load(name), OpenCLBackend("float32", family="cpu")
    planes: dict[str, Any] = {
        name: np.broadcast_to(plane, picture.shape) for name, plane in entry.planes(picture).items()
    }
    ends = []
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, boundary=boundary, limit=300.0, without=without).start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])


def test_masked_tiles_that_read_far_sleep_and_wake_up() -> None:
    """A wave that begins in a corner of a torus and goes two cells at a time; the last tiles are narrow."""
    A, rng, shape = np.zeros((5, 5)), np.random.default_rng(5), (2, 109, 141)
    A[2, 2], A[[0, 2, 2, 4], [2, 0, 4, 2]] = 3, 1
    x = np.ones(shape)
    x[0, :4, :4] = -1
    given: Any = {
        "state": x, "input": np.where(rng.random(shape) > 0.9, 1.0, -1.0), "mask": rng.uniform(-1, 0.05, shape),
        "boundary": PERIODIC, "scheme": "euler", "limit": 300.0,
    }  # fmt: skip
    ends, backend = [], OpenCLBackend("float64", family="cpu")
    for without in ([], ["sleep"]):
        task = make_task(Template(A, [[4.0]], -1.0), **given, without=without)
        assert ("sleep" in task.plan.savings) == (not without)
        end = task.start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])
    assert ends[0][2] and np.mean(ends[0][0][0] < 0) > 0.2


def test_a_tile_coasts_while_no_output_in_it_can_change_and_then_sleeps(monkeypatch: pytest.MonkeyPatch) -> None:
    entry, backend, seen = library.load("hole-filler"), OpenCLBackend("float32", family="cpu"), list[Any]()
    steps = DeviceLinearSteps.advance

    def advance(self: Any, step: int, count: int) -> None:
        steps(self, step, count)
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[(self._launches - 1) % 2])
        seen.append(found)

    monkeypatch.setattr(DeviceLinearSteps, "advance", advance)
    picture = np.full((2, 150, 265), -1.0)
    picture[0] = 1  # nothing can change in this grid, and in the other a wave goes through all
    planes: dict[str, Any] = {k: np.broadcast_to(plane, picture.shape) for k, plane in entry.planes(picture).items()}
    make_task(entry.template, **planes, boundary=fixed(-1.0), limit=40.0).start(backend)
    flags = np.array(seen).reshape(len(seen), 2, -1)
    assert (flags[:, 0] <= 1).all() and (flags[:5, 0] == 1).all(), "it coasts: its states still change"
    assert (flags[-1, 0] == 0).all(), "it sleeps"
    assert (flags[-1, 1] > 1).any(), "the other one is awake"
