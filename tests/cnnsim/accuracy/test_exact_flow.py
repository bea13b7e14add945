"""The exact flow: dense matrix exponentials, DOP853 and thirty digits give the same state, whatever the boundary."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed
from cnnsim.accuracy.linear.exact_flow import exact_state
from cnnsim.accuracy.linear.system import LinearSystem, linear_system
from cnnsim.network.cell import uncoupled_state
from cnnsim.support import Floats
from cnnsim.task import make_task
from tests.kits.backends import REFERENCE
from tests.oracles import exact_transient

BOUNDARIES = [ZERO_FLUX, PERIODIC, fixed(0.3), fixed(-1.0)]


def _case(seed: int, most: int = 5, side: int = 3) -> tuple[Floats, Floats, Floats, Any, float]:
    """A random template, its drive, a state with saturated cells, a boundary and a time."""
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, most + 1, 2))
    A = rng.normal(size=(side, side))
    A *= rng.uniform(0.5, 5) / np.abs(A).sum()
    A[side // 2, side // 2] += rng.integers(3)
    x = rng.uniform(-1.5, 1.5, shape)
    return A, rng.normal(size=shape), x, BOUNDARIES[seed % 4], float(rng.uniform(0.5, 6))


def _system(A: Floats, w: Floats, boundary: Any, *, limited: bool = False) -> LinearSystem:
    system = linear_system(Template(A).feedback_taps, w.shape, boundary, limited=limited)
    return system.with_planes(w.ravel(), np.ones(w.size, bool))


def _ours(A: Floats, w: Floats, x: Floats, boundary: Any, duration: float) -> Floats:
    return exact_state(_system(A, w, boundary), x.ravel(), duration).reshape(x.shape)


@pytest.mark.parametrize("seed", range(8))
def test_it_is_that_of_dense_matrix_exponentials(seed: int) -> None:
    case = _case(seed, side=5 if seed == 3 else 3)
    A, w, x, boundary, duration = case
    assert np.abs(_ours(*case) - exact_transient.exact(A, w, x, boundary, duration)).max() < 1e-11


@pytest.mark.parametrize("seed", [4, 5])
def test_the_oracle_is_that_of_scipy_and_of_thirty_digits(seed: int) -> None:
    case = _case(seed, most=2)
    oracle = exact_transient.exact(*case)
    assert np.abs(oracle - exact_transient.by_scipy(*case)).max() < 1e-8
    assert np.abs(oracle - exact_transient.in_many_digits(*case, digits=30)).max() < 1e-12
    assert np.abs(_ours(*case) - exact_transient.in_many_digits(*case, digits=30)).max() < 1e-13


def test_masked_cells_stay_and_drive_their_neighbours() -> None:
    A, w, x, boundary, duration = _case(6)
    mask = x > 0.2
    system = linear_system(Template(A).feedback_taps, x.shape, boundary).with_planes(w.ravel(), ~mask.ravel())
    found = exact_state(system, x.ravel(), duration).reshape(x.shape)
    assert np.array_equal(found[mask], x[mask])
    assert np.abs(found - exact_transient.exact(A, w, x, boundary, duration, mask)).max() < 1e-11


@pytest.mark.parametrize("model", ["chua-yang", "full-range"])
@pytest.mark.parametrize("a", [0.5, 1.0, 3.0])
def test_uncoupled_cells_follow_their_closed_form(model: Any, a: float) -> None:
    rng = np.random.default_rng(7)
    x, w = rng.uniform(-1, 1, (1, 60)), rng.normal(size=(1, 60))
    system = _system(np.array([[a]]), w, ZERO_FLUX, limited=model == "full-range")
    found = exact_state(system, x.ravel(), 2.5)
    assert np.abs(found - uncoupled_state(x, w, a, 2.5, model).ravel()).max() < 1e-12


def test_full_range_cells_stop_and_go_on_as_small_steps_have_it() -> None:
    rng = np.random.default_rng(1)
    A, x, w = np.array([[0, 0.6, 0], [-1.2, 1.5, 1.2], [0, -0.6, 0]]), rng.uniform(-1, 1, (3, 4)), np.zeros((3, 4))
    found = exact_state(_system(A, w, PERIODIC, limited=True), x.ravel(), 5.0).reshape(x.shape)
    errors = []
    for h in (2e-3, 1e-3):
        task = make_task(
            Template(A), state=x, boundary=PERIODIC, duration=5.0, cell="full-range", scheme="heun", step=h
        )
        errors.append(np.abs(REFERENCE.read(task.start(REFERENCE).x) - found).max())
    assert errors[1] < 1e-3
    assert errors[1] < 0.7 * errors[0]


def test_cells_that_start_on_their_kink_and_mirror_pictures() -> None:
    A = np.array([[0, 0.4, 0], [0.4, 2, 0.4], [0, 0.4, 0]])
    x = np.ones((4, 4))
    x[1:3, 1:3] = -1  # all cells on a kink, four and four of them alike
    w = np.full(x.shape, -0.1)
    found = _ours(A, w, x, ZERO_FLUX, 4.0)
    assert np.abs(found - exact_transient.exact(A, w, x, ZERO_FLUX, 4.0)).max() < 1e-11
    assert np.abs(found - found[::-1]).max() < 1e-13


def test_a_network_without_end_is_left() -> None:
    A = np.array([[0, 0, 0], [-1.2, 2, 1.2], [0, 0, 0]])
    x = np.array([[0.1, 0.0]])
    with pytest.raises(InputError, match="more than 20 kinks"):
        exact_state(_system(A, 0 * x, fixed(0)), x.ravel(), 1e3, most_kinks=20)
