"""Runge-Kutta steps with their kinks corrected: of order 3 where the plain scheme has 2, on every boundary and mask."""

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Boundary, Template, fixed
from cnnsim.accuracy.corrected import CorrectedSteps
from cnnsim.accuracy.corrected_loops import clipped_integral
from cnnsim.prototyping.accuracy.work_precision import reference_state
from cnnsim.support import Floats
from cnnsim.task import make_task
from tests.benchmarks.accuracy.random_cases import case

COEFFICIENTS = np.random.default_rng(4).normal(size=(40, 4)) * np.array([0.3, 1, 3, 10])[:, None].repeat(10, 0)


@pytest.mark.parametrize(
    "given", [*COEFFICIENTS.tolist(), [0.5, 1.0, 0.0, 0.0], [0.0, 4.0, -4.0, 0.0], [1.0] + 3 * [0]]
)
def test_a_clipped_cubic_is_integrated(given: list[float]) -> None:
    t = np.linspace(0, 1, 20_001)
    y = np.polyval(given[::-1], t).clip(-1, 1)
    assert clipped_integral(*map(float, given)) == pytest.approx(np.trapezoid(y, t), abs=1e-6)


def _error(given: dict[str, object], steps: int, exact: Floats) -> float:
    task = make_task(**given)  # type: ignore[arg-type]  # what `case` gives
    runs = CorrectedSteps(task.plan, (task.state, task.input, task.bias, task.mask))
    return float(np.abs(runs.run(task.state, steps) - exact).max())


def test_errors_fall_with_the_third_power_of_the_step() -> None:
    orders = []
    for seed in range(80_000, 80_005):
        one = case(seed)
        coarse, fine = (_error(one.given, round(one.given["duration"] * n), one.exact) for n in (30, 120))
        orders.append(np.log(coarse / max(fine, 1e-14)) / np.log(4))
    assert np.median(orders) > 2.7


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (5, 2), (6, 9)], ids=str)
@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC, fixed(-0.5, 0.25), fixed(0)], ids=str)
def test_every_boundary_a_wide_template_and_a_mask(shape: tuple[int, int], boundary: Boundary) -> None:
    rng = np.random.default_rng(7)
    A = 0.4 * rng.normal(size=(5, 5))
    A[2, 2] = 1.5
    given = {
        "template": Template(A, rng.normal(size=(3, 3)), 0.2), "state": rng.uniform(-1.5, 1.5, shape), "duration": 2.0,
        "input": rng.uniform(-1, 1, shape), "bias": rng.normal(size=shape), "boundary": boundary,
        "mask": rng.random(shape) < 0.2,
    }  # fmt: skip
    exact = reference_state(given)[0]
    assert _error(given, 800, exact) < 1e-6
