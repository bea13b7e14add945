"""Steps that sleeping cells missed, against the same steps one by one."""

from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import backends
from cnnsim.planning.plan import make_plan

H, STEPS, SHAPE = 0.1, 37, (70, 300)
TEMPLATE = cnnsim.Template([[0, 0, 0], [0, 2, 1], [0, 0, 0]], 1.0, 0.25)


def caught_up(x: Any, u: Any, dtype: Any) -> Any:
    where = backends.get("cpu", dtype, None, 1)
    plan = make_plan(TEMPLATE, x.shape, cnnsim.Boundary("zero-flux"), duration=100.0, step=H, scheme="euler")
    planes = where.load(x, "lam"), where.load(u, "lam")
    area = ((0, x.shape[0]), (0, x.shape[1]))
    end = where.catch_up(plan, *planes, None, None, area, STEPS)
    assert end is not None
    return where.read(end)


@pytest.mark.parametrize("values", [1, 2, 5, 40, 10**6])
def test_missed_steps_are_those_of_each_cell(values: int) -> None:
    random = np.random.default_rng(values)
    u = random.integers(0, values, SHAPE) / values
    x = 1.0 + random.integers(0, values, SHAPE) / values
    x[: SHAPE[0] // 2] = 1.5  # rows that are alike, before and behind such as are not
    wanted, drive = x.copy(), 1.0 * u + 0.25 + 2.0 + 1.0  # two taps on outputs of 1
    for _ in range(STEPS):
        wanted += H * (drive - wanted)
    assert np.array_equal(caught_up(x, u, np.float64), wanted)
    assert np.allclose(caught_up(x, u, np.float32), wanted, atol=1e-5)


def test_a_cell_goes_the_same_way_whatever_lies_beside_it() -> None:
    random = np.random.default_rng(0)
    x, u = (1.0 + random.integers(0, 3, SHAPE) / 3 for _ in range(2))
    found = caught_up(x, u, np.float32)
    for state in np.unique(x):
        for given in np.unique(u):
            alone = caught_up(np.full(SHAPE, state), np.full(SHAPE, given), np.float32)
            of = (x == state) & (u == given)
            assert (found[of] == alone[of]).all()
