"""The verb for transients, on terms: random networks of all kinds, and tables at and beside their places."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import Table, Template, Term, run_transient
from cnnsim.backends.base import Backend
from cnnsim.task import make_task
from tests.kits.networks import assert_like_the_reference, general_task, number_of_examples


def test_random_networks(backend: Backend) -> None:
    @settings(max_examples=number_of_examples(backend))
    @given(seed=st.integers(0, 2**32))
    def two_end_as_on_the_reference(seed: int) -> None:
        for planes in range(2):
            task = general_task(seed, planes)
            assert_like_the_reference(backend, make_task(**task), 1 + task["template"].state_bound(1.0))

    two_end_as_on_the_reference()


@pytest.mark.parametrize("kind", ["right", "left", "linear"])
@pytest.mark.parametrize("places", [0, 1, 2, 3, 4, 5, 6, 9])
def test_tables_at_and_beside_their_places(backend: Backend, kind: Any, places: int) -> None:
    """Numbers are eighths at distances of a quarter, so that slopes, values and differences are exact everywhere."""
    rng = np.random.default_rng(places)
    at = (np.cumsum(rng.choice([0.25, 0.5], places)) - places / 4).tolist()
    values = (rng.integers(-8, 9, places + 1) / 8).tolist()
    if kind == "linear":
        at = [*at, at[-1] + 0.5 if at else 0.0]
    table = Table("linear", at, values) if kind == "linear" else Table("step", at, values, kind)
    near = np.array([*at, -8.0, 0.0, 8.0], backend.dtype)
    inf = backend.dtype.type(np.inf)
    v = np.concatenate([near, np.nextafter(near, -inf), np.nextafter(near, inf)])
    u = np.array([v, v[::-1]], np.float64)
    template = Template(0, terms=[Term([[0.5]], "u_kl", table)])
    found = run_transient(template, state=np.zeros(u.shape), input=u, backend=backend).x
    assert np.abs(found - 0.5 * table(u)).max() <= (0 if kind != "linear" else 4 * np.finfo(backend.dtype).eps)
    # The same in the time loop: from x = 0 a step of Euler goes an eighth of the way to the drive.
    moving = Template(0, terms=[Term([[0.5]], "u_kl - x_ij", table)])
    end = run_transient(moving, state=np.zeros(u.shape), input=u, duration=0.125, step=0.125, backend=backend)
    assert np.array_equal(end.x, found / 8)
    times = Template(0, terms=[Term([[0.5]], "u_kl - x_ij", table, times="u_kl - x_ij")])
    end = run_transient(times, state=np.zeros(u.shape), input=u, duration=0.125, step=0.125, backend=backend)
    eps = np.finfo(backend.dtype).eps
    assert np.allclose(end.x, found * u / 8, rtol=4 * eps, atol=4 * eps)
