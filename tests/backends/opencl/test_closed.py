"""The closed form on OpenCL, with all kinds of rims, masks and states; memory that is used again."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Template, fixed
from cnnsim.backends import get
from cnnsim.operations.cellwise import BUILT_IN
from cnnsim.task import make_task
from tests.kits.opencl import OpenCLBackend


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
def test_cells_end_as_on_the_reference(cell: Any, dtype: str) -> None:
    """Quarters, so that cells start on both sides of 1, right on it, and where their rate is 0."""
    backend, law, rng = OpenCLBackend(dtype), get("reference", "float64"), np.random.default_rng(6)
    widest = 4 if cell == "full-range" else 6
    for a, shape in ((0.5, (2, 23, 35)), (1.0, (13, 64)), (1.25, (2, 7, 70)), (2.0, (11, 18))):
        template = Template(a, rng.integers(-3, 4, (3, 3)) / 4, 0.25)
        given: dict[str, Any] = {
            "state": rng.integers(-widest, widest + 1, shape) / 4,
            "input": rng.integers(-4, 5, shape) / 4,
            "mask": rng.uniform(-1, 0.3, shape),
            "bias": rng.integers(-2, 3, shape) / 4,
        }
        task = make_task(template, **given, boundary=fixed(0.5), cell=cell, duration="settled")
        ours, theirs = backend.read(task.start(backend).x), law.read(task.start(law).x)
        assert task.plan.method == "closed form"
        assert np.allclose(ours, theirs, rtol=0, atol=2e-6 if dtype == "float32" else 1e-14)


def test_the_memory_of_planes_without_a_name_is_used_again() -> None:
    backend = OpenCLBackend()
    plane, pool = backend.load(np.ones((1031, 1033), np.float32), "lam"), backend._context._pool
    add, used = BUILT_IN["add"], set[int]()
    for _ in range(3):
        total = backend.cellwise(add, [plane, plane], ())[0]
        assert backend.read(total)[-1, -1] == 2
        del total
        used.add(pool.managed_bytes)
    assert len(used) == 1
    kept = backend.cellwise(add, [plane, plane], ())[0]
    array = backend.read(backend.cellwise(add, [kept, plane], ())[0], copy=False)
    backend.cellwise(add, [plane, array_plane := backend.load(np.zeros(plane.shape), "lam")], ())
    assert backend.read(array_plane)[0, 0] == 0
    assert (backend.read(kept)[0, 0], array[0, 0]) == (2, 3)
