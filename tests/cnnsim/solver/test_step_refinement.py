"""Step refinement against the exact transient: corrected kinks have order 3, on every boundary and mask."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cnnsim import PERIODIC, ZERO_FLUX, Boundary, Template, Term, fixed, run_transient
from cnnsim.backends.reference.drive import control
from cnnsim.prototyping.accuracy.work_precision import reference_state
from cnnsim.solver.corrected_rk4 import clipped_integral
from cnnsim.solver.step_refinement import _corrected_run
from cnnsim.support import Floats
from cnnsim.task import make_task
from tests.benchmarks.accuracy.families import families
from tests.benchmarks.accuracy.random_cases import case
from tests.kits.backends import REFERENCE
from tests.oracles.exact_transient import by_scipy, exact

COEFFICIENTS = np.random.default_rng(4).normal(size=(8, 4)) * np.array([0.1, 0.3, 1, 1])[:, None].repeat(2, 0)


@pytest.mark.parametrize("given", [*COEFFICIENTS.tolist(), [0.5, 1.0, 0.0, 0.0], [1.0] + 3 * [0]])
def test_a_clipped_cubic_is_integrated(given: list[float]) -> None:
    t = np.linspace(0, 1, 20_001)
    bend = np.abs(given[2:]).sum() * 6
    y = np.polyval(given[::-1], t).clip(-1, 1)
    assert clipped_integral(*map(float, given)) == pytest.approx(np.trapezoid(y, t), abs=1e-6 + bend / 8**2 / 8)


def _error(given: dict[str, Any], steps: int, truth: Floats) -> float:
    task = make_task(**given)
    return float(np.abs(_corrected_run(task.problem())(task.state, 16 * -(-steps // 16))[-1] - truth).max())


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
    given: dict[str, Any] = {
        "template": Template(A, rng.normal(size=(3, 3)), 0.2), "state": rng.uniform(-1.5, 1.5, shape), "duration": 2.0,
        "input": rng.uniform(-1, 1, shape), "bias": rng.normal(size=shape), "boundary": boundary,
        "mask": rng.random(shape) < 0.2,
    }  # fmt: skip
    drive = control(make_task(**given).plan, given["state"], given["input"], given["bias"])
    truth = exact(A, drive, given["state"], boundary, 2.0, given["mask"])
    assert _error(given, 800, truth) < 1e-6
    assert np.abs(run_transient(**given, accuracy="exact", dtype="float64").x - truth).max() < 1e-10


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_the_exact_transient_is_that_of_dop853(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, w, x = 2 * rng.normal(size=(3, 3)) / 3, rng.normal(size=(2, 3)), rng.uniform(-1.5, 1.5, (2, 3))
    boundary = [ZERO_FLUX, PERIODIC, fixed(0.3)][seed % 3]
    assert np.abs(exact(A, w, x, boundary, 4.0) - by_scipy(A, w, x, boundary, 4.0)).max() < 1e-8


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4])
def test_full_range_cells_are_followed_to_their_limits(accuracy: float) -> None:
    rng = np.random.default_rng(1)
    A, x, w = np.array([[0, 0.6, 0], [-1.2, 1.5, 1.2], [0, -0.6, 0]]), rng.uniform(-1, 1, (3, 4)), np.zeros((3, 4))
    truth = exact(A, w, x, PERIODIC, 5.0, limited=True)
    found = run_transient(Template(A), state=x, boundary=PERIODIC, duration=5.0, cell="full-range", accuracy=accuracy)
    assert np.abs(found.x - truth).max() <= accuracy
    fine = make_task(Template(A), state=x, boundary=PERIODIC, duration=5.0, cell="full-range", scheme="heun", step=1e-3)
    assert np.abs(REFERENCE.read(fine.start(REFERENCE).x) - truth).max() < 1e-3


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
def test_growing_errors_of_a_chaotic_network_are_counted(accuracy: float) -> None:
    """Three cells of Zou and Nossek (1993), coupled through a space-variant term: errors grow by 10^4 until t = 20."""
    weights, rows = np.array([[1.25, -3.2, -3.2], [-3.2, 1.1, -4.4], [-3.2, 4.4, 1.0]]), np.zeros((5, 5, 1, 3))
    for i in range(3):
        for j in range(3):
            rows[2, 2 + j - i, 0, i] = weights[i, j]
    template = Template(0, terms=[Term(rows, "y_kl")])
    truth = solve_ivp(
        lambda _t, x: weights @ x.clip(-1, 1) - x, (0, 20), np.full(3, 0.1), "DOP853", rtol=1e-12, atol=1e-13,
        max_step=0.01,
    ).y[:, -1]  # fmt: skip
    found = run_transient(template, state=np.full((1, 3), 0.1), boundary=fixed(0), duration=20.0, accuracy=accuracy)
    assert np.abs(found.x - truth).max() <= min(accuracy, found.error)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-8])
def test_a_delayed_cell_follows_the_method_of_steps(accuracy: float) -> None:
    """Of dx/dt = -x + w x(t - d), x = x0 before 0: two intervals of one delay, integrated by hand."""
    delay, weight, x0, t = 0.5, -0.9, 0.8, 1.0
    first = weight * x0 + (1 - weight) * x0 * np.exp(-delay)
    truth = weight**2 * x0 + (first - weight**2 * x0 + weight * (1 - weight) * x0 * (t - delay)) * np.exp(delay - t)
    late = Template([[0.0]], terms=[Term([[weight]], "x_kl", delay=delay)])
    found = run_transient(late, state=np.full((2, 3), x0), duration=t, accuracy=accuracy)
    assert np.abs(found.x - truth).max() <= min(accuracy, 2 * found.error)
    assert found.plan.steps <= 50_000


@pytest.mark.parametrize("name", ["delayed", "layered"])
@pytest.mark.parametrize("accuracy", [1e-2, 1e-4])
def test_delays_and_layers_are_followed(name: str, accuracy: float) -> None:
    given = families()[name]
    truth, _ = reference_state(given)
    found = run_transient(**given, accuracy=accuracy)
    assert np.abs(found.x - truth).max() <= min(accuracy, found.error)


def test_the_estimate_is_not_below_the_last_difference() -> None:
    for seed in range(80_010, 80_016):
        found = run_transient(**case(seed).given, accuracy=1e-4)
        difference = float(found.how.split("differ by ")[1].split(";")[0])
        assert found.error >= 0.99 * difference
