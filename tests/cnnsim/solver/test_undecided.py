"""Cells near a separatrix or at the edge of a step of a table: they end on the right side, or are undecided."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Table, Template, Term, fixed, library, run_transient
from cnnsim.backends.reference.drive import control
from cnnsim.library.catalogue import run_example
from tests.benchmarks.accuracy.library_signs import large
from tests.benchmarks.accuracy.random_cases import case
from tests.oracles.exact_transient import exact


@pytest.mark.parametrize("seed", [300019, 300216, 300315, 300430, 301071, 320341, 900397])
def test_runs_that_pass_a_separatrix_on_its_wrong_side_are_refined(seed: int) -> None:
    one = case(seed)
    for accuracy in (1e-1, 1e-2):
        found = run_transient(**one.given, accuracy=accuracy, dtype="float64")
        assert np.abs(found.x - one.exact).max() <= accuracy, found.how


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_inputs_at_the_edge_of_a_step_are_named(dtype: Any) -> None:
    term = Term([[0, 1, 0], [1, 0, 1], [0, 1, 0]], "u_kl - u_ij", Table("step", (0.01,), (1.0, -1.0)))
    template = Template([[0, 0, 0], [0, 3, 0], [0, 0, 0]], z=-3, terms=[term])
    u = np.full((3, 5), -1.0)
    u[1, 1], u[1, 2] = 0.76, 0.77  # 0.77 - 0.76 is 0.01 and a last digit in float64, less in float32
    found = run_transient(
        template, state=np.zeros_like(u), input=u, boundary=fixed(-1), accuracy="binary", dtype=dtype
    )  # fmt: skip
    assert found.y[1, 1] == -1
    assert [1, 1] in found.undecided.tolist()
    assert len(found.undecided) <= 2
    assert "last digit" in found.how
    whole = np.where(u > 0, 1.0, -1.0)
    clear = run_transient(template, state=np.zeros_like(u), input=whole, boundary=fixed(-1), accuracy="binary")
    assert len(clear.undecided) == 0


def test_inputs_at_an_edge_that_change_no_sign_are_not_named() -> None:
    term = Term([[0, 1, 0], [1, 0, 1], [0, 1, 0]], "u_kl - u_ij", Table("step", (0.01,), (1.0, -1.0)))
    u = np.array([[0.76, 0.77, 0.2], [0.9, 0.9, 0.9], [0.1, -0.3, 0.2]])  # 0.77 - 0.76 again; but 0.9 is higher still
    for z, named in ((-3.0, []), (-1.0, [[0, 0]])):  # one neighbour that is higher is enough; it takes two
        template = Template([[0, 0, 0], [0, 3, 0], [0, 0, 0]], z=z, terms=[term])
        found = run_transient(
            template, state=np.zeros_like(u), input=u, boundary=fixed(-1), accuracy="binary", dtype="float64"
        )  # fmt: skip
        assert found.undecided.tolist() == named


def test_halftones_of_a_mirrored_picture_are_right_or_undecided() -> None:
    """The transient of a 5 x 5 halftone from starts changed by 1e-13: signs that all share are decided."""
    entry = library.load("halftone-5x5")
    example = large(entry.examples[0], 12)
    found = run_example(entry, example, accuracy="binary")
    u, rng = example.input, np.random.default_rng(3)
    assert u is not None
    plan = found.plan
    drive = control(plan, u, u, None)
    starts = [u + 1e-13 * sign for sign in (0.0, *rng.choice([-1.0, 1.0], (2, *u.shape)))]
    ends = np.array([exact(plan.template.A, drive, start, plan.boundary, 60.0) > 0 for start in starts])
    decided = (ends == ends[0]).all(axis=0)
    decided[tuple(found.undecided.T)] = False
    assert decided.mean() > 0.5
    assert np.array_equal((found.y > 0)[decided], ends[0][decided])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["halftone-3x3", "halftone-5x5", "halftone-5x5-crounse", "random"])
def test_no_sign_is_wrong_unless_its_cell_is_undecided(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:32, :32] / 32
    u = np.clip(np.sin(3 * cols + seed) * np.cos(4 * rows) + rng.uniform(-0.1, 0.1, (32, 32)), -1, 1)
    if name == "random":
        A = rng.normal(0, 0.5, (3, 3))
        A[1, 1] = rng.uniform(1, 2)
        template, boundary = Template((A + A[::-1, ::-1]) / 2, rng.normal(0, 0.5, (3, 3)), 0.1), fixed(0)
    else:
        entry = library.load(name)
        template, boundary = entry.template, entry.boundary
    given: dict[str, Any] = {"template": template, "state": u, "input": u, "boundary": boundary}
    found = run_transient(**given, accuracy="binary")
    truth = run_transient(**given, scheme="rk4", step=0.02, dtype="float64")
    wrong = (found.y > 0) != (truth.y > 0)
    wrong[tuple(found.undecided.T)] = False
    assert truth.settled
    assert not wrong.any()
    assert len(found.undecided) <= 10
