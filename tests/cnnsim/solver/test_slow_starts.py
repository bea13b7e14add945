"""Slow states that are no rest: near a separatrix, with a constant rate, or both under modes that decay."""

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity

from cnnsim import PERIODIC, ZERO_FLUX, Cell, LayeredTemplate, NotSettledError, Template, Term, fixed
from cnnsim import run_transient as run
from cnnsim.backends import NAMES
from cnnsim.network.characteristic import Characteristic
from cnnsim.solver.linear_rest import is_stable
from cnnsim.solver.sparse_solve import solve_sparse
from tests.kits.backends import build
from tests.oracles.exact_transient import coupling

PULL = np.array([[0, 0.5, 0], [0.5, 2, 0.5], [0, 0.5, 0]])
HEAT = np.array([[0, 0.25, 0], [0.25, 0, 0.25], [0, 0.25, 0]])
TERMS = Template(0, terms=[Term(PULL, "y_kl")])
ONES = np.ones((3, 4))


@pytest.mark.parametrize("name", NAMES)
def test_a_small_start_leaves_a_separatrix_on_every_backend(name: str) -> None:
    found = run(Template(PULL), state=1e-6 * ONES, boundary=fixed(0), backend=build(name, None, None))
    assert (found.y == 1).all()
    assert not len(found.undecided)


@pytest.mark.parametrize("scale", [1e-3, 1e-5, 1e-8])
@pytest.mark.parametrize("of", ["state", "bias", "input"])
@pytest.mark.parametrize("template", [Template(PULL, 1), Template(0, 1, terms=TERMS.terms)], ids=["linear", "terms"])
def test_no_drive_is_too_small(template: Template, of: str, scale: float) -> None:
    given: dict[str, Any] = {"state": 0 * ONES, "input": 0 * ONES, "boundary": fixed(0), of: scale * ONES}
    assert (run(template, **given).y == 1).all()
    assert (run(template, **given, accuracy=1e-3).y == 1).all()


@pytest.mark.parametrize("cell", [Cell("discrete-time", Characteristic()), Cell("full-range")], ids=str)
def test_no_cell_model_and_no_layer_hides_growth(cell: Cell) -> None:
    assert (run(Template(PULL), state=1e-6 * ONES, boundary=fixed(0), cell=cell).y == 1).all()
    layers = LayeredTemplate([TERMS, Template(0.5)])
    assert (run(layers, state=np.stack([1e-7 * ONES, 1e-2 * ONES]), boundary=fixed(0), cell=cell).y[0] == 1).all()


def test_a_slow_start_of_oscillations_does_not_settle() -> None:
    turn = Template([[0.0, 0.0, 0.0], [-0.5, 1.3, 0.5], [0.0, 0.0, 0.0]])
    with pytest.raises(NotSettledError, match="far from its end"):
        run(turn, state=np.array([[1e-7, 0, -1e-7, 0]]), boundary=fixed(0))


def test_terms_at_rest_on_a_separatrix_are_undecided() -> None:
    assert len(run(TERMS, state=0 * ONES, boundary=fixed(0)).undecided) == ONES.size


@pytest.mark.parametrize("seed", range(8))
def test_a_constant_rate_under_a_fast_mode_does_not_settle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.uniform(0, 1, (3, 3)) if seed % 2 else HEAT
    A, z = A / A.sum(), rng.choice([-1, 1]) * 10.0 ** -rng.uniform(4.5, 8)
    given: dict[str, Any] = {"state": rng.uniform(-0.7, 0.7, (3, 4)), "boundary": PERIODIC, "limit": 60.0}
    for template in (Template(A, 0, z), Template(0, 0, z, terms=[Term(A, "y_kl")])):
        for accuracy in (None, "binary"):
            with pytest.raises(NotSettledError):
                run(template, **given, accuracy=accuracy)
    assert run(Template(A), **given).settled
    assert run(Template(0, terms=[Term(A, "y_kl")]), **given).settled


@pytest.mark.parametrize("z", [-1e-5, -1e-8])
def test_saturated_cells_that_drift_do_not_settle(z: float) -> None:
    with pytest.raises(NotSettledError):
        run(Template(HEAT, 0, z), state=ONES, boundary=ZERO_FLUX, limit=30.0)
    assert run(Template(HEAT), state=ONES, boundary=ZERO_FLUX).settled


def test_singular_systems_are_solved_or_have_no_solution() -> None:
    rng = np.random.default_rng(3)
    wave = rng.uniform(0, 1, (9, 9))
    leak = csr_matrix(np.eye(9) - wave / wave.sum(axis=1, keepdims=True)).tocsc()
    reached = leak @ rng.normal(size=9)
    found = solve_sparse(leak, reached, 1e-3)
    assert found is not None
    assert np.abs(leak @ found - reached).max() < 1e-9
    none = solve_sparse(leak, reached + 1e-6, 1e-3)
    assert none is not None
    assert np.isinf(none).all()


@pytest.mark.parametrize("growth", [-1e-3, 1e-3])
def test_large_matrices_that_are_not_symmetric_are_judged(growth: float) -> None:
    A = np.array([[0.0, 0.3, 0.0], [0.6, 0.0, -0.1], [0.0, 0.2, 0.0]])
    matrix, _ = coupling(A / A.sum() * (1 + growth), (21, 23), PERIODIC)
    assert is_stable((identity(21 * 23) - csr_matrix(matrix)).tocsc()) == (growth < 0)
