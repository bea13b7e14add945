"""Two cells that oscillate and three that are chaotic, against scipy at tight tolerance."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from cnnsim import Template, fixed, run_transient
from cnnsim.network import LayeredTemplate, Term

both = pytest.mark.parametrize("backend", ["reference", "cpu"])
ZOU_NOSSEK = np.array([[1.25, -3.2, -3.2], [-3.2, 1.1, -4.4], [-3.2, 4.4, 1.0]])
"""x' = -x + M f(x): p = 1.25, 1.1, 1, s = 3.2, r = 4.4. Zou and Nossek, IEEE Trans. CAS-I 40 (1993) 166."""
START = np.array([0.1, 0.1, 0.1])


def exact(matrix: NDArray[np.float64], start: NDArray[np.float64], time: float) -> NDArray[np.float64]:
    """DOP853, with steps that stay short at the kinks of the output."""
    found = solve_ivp(
        lambda _t, x: -x + matrix @ x.clip(-1, 1), (0, time), start, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.01
    )
    return np.asarray(found.y[:, -1])


def pair_of(s: float) -> NDArray[np.float64]:
    """A with s to the right and -s to the left, 2 in the centre."""
    return np.array([[0, 0, 0], [-s, 2, s], [0, 0, 0]])


def in_layers(matrix: NDArray[np.float64]) -> LayeredTemplate:
    """Each variable a layer of one cell."""
    n = len(matrix)
    return LayeredTemplate([
        Template(matrix[l, l], terms=[Term([[matrix[l, m]]], "y_kl", layer=m) for m in range(n) if m != l])
        for l in range(n)
    ])  # fmt: skip


def in_a_row(matrix: NDArray[np.float64]) -> Template:
    """Each variable a cell of a row, the weights different in every cell."""
    n = len(matrix)
    weights = np.zeros((2 * n - 1, 2 * n - 1, 1, n))
    for i in range(n):
        for j in range(n):
            weights[n - 1, n - 1 + j - i, 0, i] = matrix[i, j]
    return Template(0, terms=[Term(weights, "y_kl")], name="row")


@both
def test_three_chaotic_cells(backend: str) -> None:
    wanted = exact(ZOU_NOSSEK, START, 8.0)
    task: dict[str, Any] = {"duration": 8.0, "scheme": "rk4", "step": 0.002, "backend": backend, "dtype": "float64"}
    layers = run_transient(in_layers(ZOU_NOSSEK), state=START.reshape(3, 1, 1), **task).x.ravel()
    row = run_transient(in_a_row(ZOU_NOSSEK), state=START.reshape(1, 3), boundary=fixed(0), **task).x.ravel()
    assert np.abs(layers - wanted).max() < 2e-4
    assert np.abs(row - wanted).max() < 2e-4


def test_the_adaptive_reference_of_a_chaotic_network() -> None:
    end = run_transient(in_layers(ZOU_NOSSEK), state=START.reshape(3, 1, 1), duration=8.0, scheme="adaptive",
                        backend="reference").x.ravel()  # fmt: skip
    assert np.abs(end - exact(ZOU_NOSSEK, START, 8.0)).max() < 1e-6


def test_it_is_chaotic() -> None:
    """Neighbouring starts part, and the states stay bounded."""
    task: dict[str, Any] = {"duration": 120.0, "scheme": "rk4", "step": 0.01, "backend": "cpu", "dtype": "float64"}
    starts = np.array([START, START + 1e-8]).reshape(2, 3, 1, 1)
    ends = run_transient(in_layers(ZOU_NOSSEK), state=starts, **task).x
    assert np.abs(ends[0] - ends[1]).max() > 1e-3
    assert np.abs(ends).max() < 10.05


@both
def test_two_cells_with_opposite_signs_oscillate_beyond_a_minus_one(backend: str) -> None:
    """Zou and Nossek 1991: a = 2 settles for s = 0.9 and oscillates for s = 1.2."""
    task: dict[str, Any] = {
        "boundary": fixed(0),
        "scheme": "rk4",
        "step": 0.01,
        "backend": backend,
        "dtype": "float64",
    }
    start = np.array([0.1, 0.1])
    for s in (0.9, 1.2):
        pair = Template(pair_of(s))
        end = run_transient(pair, state=start.reshape(1, 2), duration=10.0, **task).x.ravel()
        assert np.abs(end - exact(np.array([[2, s], [-s, 2]]), start, 10.0)).max() < 1e-4
    task["backend"] = "cpu"
    turning = [
        run_transient(Template(pair_of(1.2)), state=[start], duration=t, **task).x[0, 0]
        for t in np.arange(20.0, 32.0, 0.5)
    ]
    assert min(turning) < -1
    assert max(turning) > 1
    assert run_transient(Template(pair_of(0.9)), state=[start], boundary=fixed(0)).settled
