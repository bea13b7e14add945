"""Cells in discrete time: Harrer and Nossek's theorems."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import InputError, Template, fixed, run_transient
from cnnsim.network import Cell, Characteristic

both = pytest.mark.parametrize("backend", ["reference", "cpu"])


@both
def test_without_feedback_one_step_is_enough(backend: str) -> None:
    rng = np.random.default_rng(1)
    t, u = Template(0, rng.normal(size=(3, 3)), 0.3), rng.uniform(-1, 1, (6, 7))
    result = run_transient(t, state=0 * u, input=u, cell="discrete-time", backend=backend)
    assert result.settled
    assert result.t == 1
    assert np.array_equal(result.y, np.sign(result.y))


@both
@settings(max_examples=30)
@given(seed=st.integers(0, 2**32))
def test_symmetric_feedback_ends_in_a_fixed_point_or_a_cycle_of_two(backend: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(3, 3))
    t, x = Template(a + a[::-1, ::-1], z=rng.normal()), rng.choice([-1.0, 1.0], (5, 6))
    task: dict[str, Any] = {"boundary": fixed(-1), "cell": "discrete-time", "backend": backend}
    late = run_transient(t, state=x, duration=60.0, **task).y
    assert np.array_equal(run_transient(t, state=late, duration=2.0, **task).y, late)


@both
def test_a_cycle_of_two_is_not_settled(backend: str) -> None:
    blink = Template([[-1.0]])
    with pytest.raises(InputError, match="has not settled"):
        run_transient(blink, state=[[1.0, -1.0]], cell="discrete-time", backend=backend)


@both
def test_a_drive_of_zero_keeps_the_output(backend: str) -> None:
    nothing = Template(0)
    y = run_transient(nothing, state=[[0.3, -0.2, 0.0]], cell="discrete-time", backend=backend).y
    assert y.tolist() == [[1.0, -1.0, 0.0]]


@both
def test_euler_with_step_one_is_the_discrete_cell(backend: str) -> None:
    rng = np.random.default_rng(4)
    a, b, x, u = rng.normal(size=(3, 3)) * 0.1, rng.normal(size=(3, 3)), *rng.uniform(-1, 1, (2, 5, 6))
    discrete = run_transient(
        Template(a, b), state=x, input=u, duration=4.0, cell=Cell("discrete-time", Characteristic()), backend=backend
    )
    euler = run_transient(Template(a, b), state=x, input=u, duration=4.0, scheme="euler", step=1.0, backend=backend)
    assert np.allclose(discrete.y, euler.y, atol=1e-6)
