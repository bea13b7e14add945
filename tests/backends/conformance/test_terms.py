"""The verb for transients, on terms: random networks of all kinds, and tables at their places and next to them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import LayeredTemplate, Table, Template, Term, run_transient
from cnnsim.backends.base import Backend
from cnnsim.network import ZERO_FLUX, AnyTemplate
from cnnsim.network.table import lines
from cnnsim.task import make_task
from tests.kits.backends import COMPILING
from tests.kits.networks import assert_like_the_reference, general_task, number_of_examples


def test_random_networks(backend: Backend) -> None:
    @settings(max_examples=number_of_examples(backend))
    @given(seed=st.integers(0, 2**32))
    def two_end_as_on_the_reference(seed: int) -> None:
        for planes in range(2):
            task = general_task(seed, planes)
            assert_like_the_reference(backend, make_task(**task), 1 + task["template"].state_bound(1.0))

    two_end_as_on_the_reference()


PLACES = [0, 1, 2, 3, 4, 5, 6, 9]


def table_of(kind: Any, places: int) -> Table:
    """A random table; its numbers are eighths at distances of a quarter: slopes, values and differences are exact."""
    rng = np.random.default_rng(places)
    at: Any = (np.cumsum(rng.choice([0.25, 0.5], places)) - places / 4).tolist()
    values = (rng.integers(-8, 9, places + 1) / 8).tolist()
    if kind == "linear":
        return Table("linear", (*at, at[-1] + 0.5 if at else 0.0), values)
    return Table("step", at, values, kind)


def at_and_beside(table: Table, dtype: np.dtype[Any]) -> np.ndarray:
    """The places of a table, far beyond them, and the numbers next to each (2, n)."""
    near, inf = np.array([*table.at, -8.0, 0.0, 8.0], dtype), dtype.type(np.inf)
    v = np.concatenate([near, np.nextafter(near, -inf), np.nextafter(near, inf)])
    return np.array([v, v[::-1]], np.float64)


def assert_exact(backend: Backend, tables: list[Table], u: np.ndarray, template: Callable[..., AnyTemplate]) -> None:
    """Run the ``template`` of a kind of term on inputs (tables, 2, n), or (2, n) for one table.

    From x = 0 a step of Euler goes an eighth of the way to the drive.
    """
    eps = np.finfo(backend.dtype).eps
    step: dict[str, Any] = {"duration": 0.125, "step": 0.125, "backend": backend}
    wanted = 0.5 * np.array([table(of) for table, of in zip(tables, u.reshape(-1, *u.shape[-2:]), strict=True)])
    wanted, start = wanted.reshape(u.shape), np.zeros(u.shape)
    of_input = template("u_kl")
    alone = not isinstance(of_input, LayeredTemplate)
    found = run_transient(of_input, state=start, input=u, **({"backend": backend} if alone else step)).x
    found = found if alone else found * 8  # a power of two: exact
    assert np.abs(found - wanted).max() <= (4 * eps if tables[0].kind == "linear" else 0)
    end = run_transient(template("u_kl - x_ij"), state=start, input=u, **step)
    assert np.array_equal(end.x, found / 8)
    end = run_transient(template("u_kl - x_ij", "u_kl - x_ij"), state=start, input=u, **step)
    assert np.allclose(end.x, found * u / 8, rtol=4 * eps, atol=4 * eps)


@pytest.mark.parametrize("kind", ["right", "left", "linear"])
def test_tables_at_and_beside_their_places(backend: Backend, kind: Any) -> None:
    """One in each layer: a backend that writes tables into its text builds all of them at once."""
    tables = [table_of(kind, places) for places in PLACES]
    ends = [at_and_beside(table, backend.dtype) for table in tables]
    u = np.array([np.pad(v, ((0, 0), (0, ends[-1].shape[1] - v.shape[1]))) for v in ends])

    def layers(of: str, times: str | None = None) -> LayeredTemplate:
        return LayeredTemplate([Template(0, terms=[Term([[0.5]], of, table, times)]) for table in tables])

    assert_exact(backend, tables, u, layers)


@pytest.mark.parametrize("kind", ["right", "left", "linear"])
@pytest.mark.parametrize("places", PLACES)
def test_a_table_alone(backend: Backend, kind: Any, places: int) -> None:
    if backend.name in COMPILING and places != PLACES[-1]:
        pytest.skip("each builds a kernel of its own; the same tables are layers above")
    table = table_of(kind, places)

    def single(of: str, times: str | None = None) -> Template:
        return Template(0, terms=[Term([[0.5]], of, table, times)])

    assert_exact(backend, [table], at_and_beside(table, backend.dtype), single)


@pytest.mark.parametrize("points", [
    [(-2, 0.5), (-0.25, 0.5), (0, 1), (0.25, 0.125), (2, 0.125)],  # a hat on two levels
    [(-2, 0.5), (-1, 0.5), (-0.25, 0.5), (0.5, -1)],  # a ramp that begins late
    [(-1, 0.25), (0, 0.25), (1, 0.25)],  # nothing but ends
])  # fmt: skip
def test_a_table_goes_on_as_it_ends(backend: Backend, points: Any) -> None:
    """A linear table is held at its ends, and where it begins or ends flat nothing is looked up."""
    differences = Template(0.5, terms=[Term(np.full((3, 3), 1 / 16), "y_kl - y_ij", lines(*points))])
    squared = Template(0.5, terms=[Term(np.full((3, 3), 1 / 16), "x_kl - x_ij", lines(*points), times="x_kl - x_ij")])
    state = np.random.default_rng(3).integers(-16, 17, (9, 70)) / 16
    for template in (differences, squared):
        task: dict[str, Any] = {
            "state": state,
            "boundary": ZERO_FLUX,
            "duration": 0.25,
            "scheme": "euler",
            "step": 0.25,
        }
        ours = run_transient(template, **task, backend=backend).x
        wanted = run_transient(template, **task, backend="reference").x
        np.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-5 if backend.dtype == np.float32 else 1e-13)
