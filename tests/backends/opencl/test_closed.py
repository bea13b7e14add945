"""The closed form on OpenCL: several rows of an input at once, with all kinds of rims, masks and states."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Template, fixed
from cnnsim.backends import get
from cnnsim.task import make_task
from tests.kits.opencl import OpenCLBackend


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
def test_rows_that_are_driven_at_once_end_as_one_by_one(cell: Any, dtype: str) -> None:
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


def test_planes_that_nobody_has_any_more_are_written_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from cnnsim.operations.cellwise import BUILT_IN

    backend = OpenCLBackend()
    plane = backend.load(np.ones((1031, 1033), np.float32), "lam")  # 4 MiB and more: smaller memory is soon there
    context, made = backend._context, list[int]()
    new = context.new

    def counted(size: int) -> Any:
        made.append(size)
        return new(size)

    monkeypatch.setattr(context, "new", counted)
    for _ in range(3):
        total = backend.cellwise(BUILT_IN["add"], [plane, plane], ())[0]
        assert backend.read(total)[-1, -1] == 2
        del total
    kept = backend.cellwise(BUILT_IN["add"], [plane, plane], ())[0]
    backend.cellwise(BUILT_IN["add"], [kept, plane], ())
    assert backend.read(kept)[0, 0] == 2
    assert made == [4 * 1031 * 1033] * 2
