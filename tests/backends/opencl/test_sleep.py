"""Sleeping tiles of the OpenCL backend on a CPU: the same bits as without, and left out where nothing changes."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
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
