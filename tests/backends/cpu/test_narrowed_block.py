"""Steps of which only an area is wanted give, in that area, the bits of those of the whole grid."""

from typing import Any

import numpy as np
import pytest

from cnnsim import backends
from cnnsim.backends.cpu.tiles import narrowing
from cnnsim.network import Template
from cnnsim.task import make_task

RANDOM = np.random.default_rng(4)
MIXED = Template([[0.1, 0.3, 0.1], [0.2, 1.5, 0.2], [0.1, 0.4, 0.1]], [[0, 0.2, 0], [0.1, 1, 0.1], [0, 0.2, 0]], -0.05)
WIDE = Template(np.full((5, 5), 0.1), 0.3)


@pytest.mark.parametrize("boundary", ["zero-flux", "periodic", "fixed:0.3,-0.2"])
@pytest.mark.parametrize(("template", "dtype"), [(MIXED, "float32"), (WIDE, "float64")])
@pytest.mark.parametrize("area", [((0, 20), (0, 150)), ((40, 60), (70, 80)), ((0, 90), (0, 150))])
def test_the_area_has_the_bits_of_the_whole(boundary: str, template: Template, dtype: Any, area: Any) -> None:
    x, u = RANDOM.uniform(-1, 1, (2, 90, 150)).astype(dtype)
    task = make_task(template, state=x, input=u, duration=3.5, step=0.1, boundary=boundary)
    where = backends.get("cpu", dtype, None, 1)
    whole = where.transient(task.plan, x, u).x
    found = where.advance(task.plan, x, u, None, None, area, task.plan.steps)
    (r0, r1), (c0, c1) = area
    assert found is not None
    assert found[r0:r1, c0:c1].tobytes() == whole[r0:r1, c0:c1].tobytes()


def test_what_can_reach_the_area_no_more_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    areas: list[tuple[int, ...]] = []
    pass_over = narrowing.pass_over

    def watched(*given: Any) -> None:
        areas.append(given[-1])
        pass_over(*given)

    monkeypatch.setattr("cnnsim.backends.cpu.block.pass_over", watched)
    x = RANDOM.uniform(-1, 1, (200, 200)).astype(np.float32)
    task = make_task(MIXED, state=x, input=x, duration=5.0, step=0.1)
    backends.get("cpu", "float32", None, 1).advance(task.plan, x, x, None, None, ((90, 110), (90, 110)), 50)
    assert areas == [(65, 135, 65, 135), (90, 110, 90, 110)]
