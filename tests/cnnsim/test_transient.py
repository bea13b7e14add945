"""What theory says of every cellular neural network, as properties of the simulator."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, run_transient
from cnnsim.network.cell import output
from cnnsim.planning.scheme import EULER, HEUN
from cnnsim.planning.stability import step_limit

seeds = st.integers(0, 2**32)
both = pytest.mark.parametrize("backend", ["reference", "cpu"])


def _random(seed: int, scale: float = 1.0) -> tuple[np.random.Generator, Template, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    t = Template(scale * rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rng.normal())
    shape = tuple(rng.integers(1, 14, size=2))
    return rng, t, rng.uniform(-1, 1, shape), rng.uniform(-1, 1, shape)


@both
@settings(max_examples=20)
@given(seed=seeds, h=st.floats(0.1, 1.0))
def test_the_state_never_leaves_the_chua_yang_bound(backend: str, seed: int, h: float) -> None:
    rng, t, x, u = _random(seed)
    for duration in (0.5, 4.0, 20.0):
        boundary = fixed(rng.uniform(-1, 1))
        limit = min(1.0, 2 / (1 + np.abs(t.A).sum()), step_limit(t, boundary, duration, EULER))
        if limit < 0.05:  # modes that turn: another scheme's business, and very many steps
            continue
        end = run_transient(t, state=x, input=u, boundary=boundary, duration=duration, scheme="euler",
                            step=h * limit, backend=backend)  # fmt: skip
        assert np.abs(end.x).max() <= max(1.0, t.state_bound()) * (1 + 1e-6)


@settings(max_examples=10)
@given(seed=seeds)
def test_a_symmetric_template_settles_and_its_energy_falls(seed: int) -> None:
    """V = -1/2 sum A y y + 1/2 sum y^2 - sum (B u + z) y never grows (Chua and Yang 1988)."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(3, 3))
    a = a + a[::-1, ::-1]
    a[1, 1] = 1 + abs(a[1, 1])  # binary outputs
    x = rng.uniform(-1, 1, (6, 7))
    z = rng.normal()
    t = Template(a, z=z)
    energies = []
    for _ in range(40):
        y = output(x)
        around = np.pad(y, 1)
        push = sum(a[k, l] * around[k : k + 6, l : l + 7] for k, l in np.ndindex(3, 3))
        energies.append(float((-0.5 * push * y + 0.5 * y * y - z * y).sum()))
        x = run_transient(t, state=x, boundary=fixed(0.0), duration=0.1, step=0.002, scheme="euler", backend="cpu",
                          dtype="float64").x  # fmt: skip
    assert np.diff(energies).max() <= 1e-3 * max(1.0, abs(energies[0]))
    end = run_transient(t, state=x, boundary=fixed(0.0), backend="cpu", limit=20_000.0)
    assert end.settled
    assert np.abs(end.y).min() > 0.99


@both
@settings(max_examples=30)
@given(seed=seeds, shift=st.tuples(st.integers(-9, 9), st.integers(-9, 9)))
def test_a_shift_on_a_torus_shifts_the_result_bit_for_bit(backend: str, seed: int, shift: tuple[int, int]) -> None:
    _, t, x, u = _random(seed)
    task: dict[str, Any] = {"boundary": PERIODIC, "duration": 2.0, "backend": backend}
    plain = run_transient(t, state=x, input=u, **task).x
    shifted = run_transient(t, state=np.roll(x, shift, (0, 1)), input=np.roll(u, shift, (0, 1)), **task).x
    assert np.array_equal(shifted, np.roll(plain, shift, (0, 1)))


@both
@settings(max_examples=30)
@given(seed=seeds)
def test_odd_symmetry_bit_for_bit(backend: str, seed: int) -> None:
    _, t, x, u = _random(seed)
    task: dict[str, Any] = {"duration": 2.0, "backend": backend}
    plain = run_transient(t, state=x, input=u, boundary=fixed(0.4, -0.2), **task).x
    negative = Template(t.A, t.B, -t.z)
    assert np.array_equal(run_transient(negative, state=-x, input=-u, boundary=fixed(-0.4, 0.2), **task).x, -plain)


@both
def test_orientation_is_correlation(backend: str) -> None:
    """The top row of a template weighs the northern neighbours, so copying the north moves the picture south."""
    dot = -np.ones((5, 5))
    dot[2, 2] = 1
    north, south = (np.roll(dot, k, axis=0) for k in (-1, 1))
    north_weighs = [[0, 1, 0], [0, 0, 0], [0, 0, 0]]
    by_control = run_transient(Template(0, north_weighs), state=0 * dot, input=dot, boundary=fixed(-1), backend=backend)
    assert np.array_equal(by_control.y, south)
    assert not np.array_equal(by_control.y, north)
    by_feedback = run_transient(Template(north_weighs), state=dot, boundary=fixed(-1), duration=1.0, step=1.0,
                                scheme="euler", backend=backend)  # fmt: skip
    assert np.array_equal(by_feedback.y, south)


@both
@settings(max_examples=20)
@given(seed=seeds)
def test_a_run_in_two_parts_is_the_run_bit_for_bit(backend: str, seed: int) -> None:
    _, t, x, u = _random(seed)
    task: dict[str, Any] = {"input": u, "scheme": "heun", "step": 0.0625, "backend": backend, "boundary": ZERO_FLUX}
    if step_limit(t, ZERO_FLUX, 2.5, HEUN) < 0.0625:
        return
    halfway = run_transient(t, state=x, duration=1.0, **task).x
    assert np.array_equal(run_transient(t, state=halfway, duration=1.5, **task).x,
                          run_transient(t, state=x, duration=2.5, **task).x)  # fmt: skip


@settings(max_examples=30)
@given(seed=seeds)
def test_comparison_principle(seed: int) -> None:
    """With A >= 0 off its centre and B >= 0, more in gives more out, everywhere and always."""
    rng = np.random.default_rng(seed)
    a, b = np.abs(rng.normal(size=(3, 3))), np.abs(rng.normal(size=(3, 3)))
    t, shape = Template(a, b), (8, 9)
    low, u = rng.uniform(-1, 1, shape), rng.uniform(-1, 1, shape)
    high, more = low + rng.uniform(0, 0.2, shape), np.clip(u + rng.uniform(0, 0.2, shape), -1, 1)
    step = min(0.1, 0.9 * step_limit(t, ZERO_FLUX, 3.0, EULER))
    task: dict[str, Any] = {"duration": 3.0, "scheme": "euler", "step": step, "dtype": "float64"}
    assert np.all(run_transient(t, state=high, input=more, **task).x >= run_transient(t, state=low, input=u, **task).x)
