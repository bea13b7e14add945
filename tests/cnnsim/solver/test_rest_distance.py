"""Settled networks are within the stated distance of their rest, on every backend; others are errors."""

from typing import Any

import numpy as np
import pytest
from scipy import fft
from scipy.sparse import csr_matrix, identity
from scipy.sparse.linalg import spsolve

from cnnsim import PERIODIC, ZERO_FLUX, InputError, NotSettledError, Template, explain, fixed, run, run_transient
from cnnsim.backends import NAMES
from cnnsim.network import LayeredTemplate, Term
from cnnsim.solver.rest_distance import SETTLED_DISTANCE
from cnnsim.support import Floats
from tests.kits.backends import build
from tests.oracles.exact_transient import coupling

HEAT = [[0, 1, 0], [1, -3, 1], [0, 1, 0]]


def _membrane(load: Floats) -> Floats:
    """The clamped membrane under a load by sines, from the definition of the five-point Laplacian."""
    rows, cols = load.shape
    p, q = np.pi * np.arange(1, rows + 1) / (rows + 1), np.pi * np.arange(1, cols + 1) / (cols + 1)
    size = 4 - 2 * np.cos(p)[:, None] - 2 * np.cos(q)
    return np.asarray(fft.idstn(fft.dstn(load, type=1) / size, type=1))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_a_clamped_membrane_ends_where_sines_say(name: str, dtype: Any) -> None:
    if name == "reference" and dtype == "float32":
        pytest.skip("the reference computes in float64 alone")
    load = np.random.default_rng(1).uniform(-1, 1, (24, 30)) * 0.05
    build(name, None, dtype)
    found = run("poisson-solver", np.zeros(load.shape), bias=load, backend=name, dtype=dtype)
    assert found.settled
    assert np.abs(found.y - _membrane(load)).max() <= SETTLED_DISTANCE
    assert np.abs(found.y - _membrane(load)).max() <= max(found.distance, 1e-6)


def test_a_large_membrane_is_no_farther_from_its_end() -> None:
    load = np.full((96, 96), 2e-4)
    found = run("poisson-solver", np.zeros(load.shape), bias=load)
    assert np.abs(found.y - _membrane(load)).max() <= SETTLED_DISTANCE
    assert "solved for" in found.how


@pytest.mark.parametrize(("name", "tolerance"), [("laplace-solver", 1e-3), ("surface-interpolation", 1e-3)])
def test_surfaces_through_masked_cells_end_where_sparse_matrices_say(name: str, tolerance: float) -> None:
    rng = np.random.default_rng(3)
    x, mask = rng.uniform(-0.2, 0.2, (12, 15)), np.where(rng.random((12, 15)) < 0.06, 1.0, -1.0)
    found = run(name, x, mask=mask)
    from cnnsim import library

    entry = library.load(name)
    A, _ = coupling(entry.template.A, x.shape, entry.boundary)
    free = (mask <= 0).ravel()
    leak = csr_matrix(identity(x.size) - A)
    right = -leak[free][:, ~free] @ x.ravel()[~free]
    y = x.ravel().copy()
    y[free] = spsolve(leak[free][:, free].tocsc(), right)
    assert np.abs(y).max() < 1
    assert np.abs(found.y.ravel() - y).max() <= tolerance
    assert np.array_equal(found.x[mask > 0], x[mask > 0].astype(found.x.dtype))


@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC], ids=str)
def test_heat_that_keeps_its_mean_ends_at_the_mean(boundary: Any) -> None:
    x = np.tile(np.linspace(-0.5, 0.9, 40), (3, 1))
    found = run_transient(Template(HEAT), state=x, boundary=boundary, dtype="float64")
    assert np.abs(found.y - x.mean()).max() <= SETTLED_DISTANCE


def test_networks_of_layers_go_on_until_their_changes_are_small() -> None:
    slow = Template(0.998, z=2e-5)  # ends at 0.01 with a rate of 2e-5 from the start
    both = LayeredTemplate([slow, Template(0.5, terms=[Term([[0.1]], "y_kl", layer=0)])])
    found = run_transient(both, state=np.zeros((2, 3, 3)), limit=1e4)
    assert np.abs(found.y[0] - 0.01).max() <= SETTLED_DISTANCE
    assert found.t > 500
    with pytest.raises(NotSettledError, match="from its end"):
        run_transient(both, state=np.zeros((2, 3, 3)), limit=100.0)


def test_a_slow_contraction_is_seen_by_its_bound() -> None:
    found = run_transient(Template([[0, 0.2, 0], [0.2, 0, 0.2], [0, 0.2, 0]]), state=np.full((5, 5), 0.5))
    assert found.distance <= 1e-4 / 0.2 * 1.01
    assert "contraction" in found.how


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_cells_on_a_separatrix_are_undecided(dtype: Any) -> None:
    template = Template([[0, 0.1, 0], [0.1, 2, 0.1], [0, 0.1, 0]])
    x = np.zeros((4, 5))
    found = run_transient(template, state=x, boundary=fixed(0), dtype=dtype)
    assert found.settled
    assert len(found.undecided) == x.size
    uncoupled = run_transient(Template(2), state=np.array([[0.0, 0.3, -0.3]]), dtype=dtype)
    assert uncoupled.undecided.tolist() == [[0, 0]]


def test_a_cell_that_slowly_leaves_its_separatrix_is_followed() -> None:
    template = Template([[0, 0.1, 0], [0.1, 2, 0.1], [0, 0.1, 0]])
    found = run_transient(template, state=np.full((3, 3), 3e-5), boundary=fixed(0), dtype="float64")
    assert (found.y == 1).all()
    assert not len(found.undecided)


def test_cells_that_rounding_decides_are_undecided() -> None:
    """A ramp of equal rows: its four middle cells are on a separatrix until rounding moves them, in float32 late."""
    ramp = np.linspace(-1, 1, 48)[None, :].repeat(32, axis=0)
    result = run("halftone-3x3", ramp, dtype="float32")
    assert (np.abs(result.x) >= 1).all()
    assert result.undecided is not None
    assert len(result.undecided) == 4


def test_a_plane_that_the_check_saw_saturated_is_not_read() -> None:
    from cnnsim.backends.base import Outcome
    from cnnsim.solver.verify_settled import verify_settled
    from cnnsim.task import make_task

    plan = make_task(Template(2), state=np.ones((3, 3)), duration="settled", step=0.1).plan
    outcome = Outcome(object(), 1.0, True, 0.0, saturated=True)  # nothing that could be read
    assert verify_settled(None, plan, outcome, None, None, None, 1e-3)[0] is outcome  # type: ignore[arg-type]  # unused


def test_a_grey_rest_that_memory_cannot_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnnsim.solver.verify_settled.LARGE", 100)
    monkeypatch.setenv("CNNSIM_MEMORY", "40K")
    heat = Template([[0, 0.24, 0], [0.24, 0, 0.24], [0, 0.24, 0]])
    x = np.random.default_rng(0).uniform(-0.9, 0.9, (20, 20))
    with pytest.raises(InputError, match="a duration instead of 'settled'"):
        run_transient(heat, state=x)
    assert "to solve for the rest" in str(explain(heat, x))
