"""Cells near a ridge, in a tie or at the edge of a table's step: gone the right way, or named."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Table, Template, Term, fixed, library, run_transient
from cnnsim.accuracy.corrected import CorrectedSteps
from cnnsim.accuracy.linear.exact_flow import exact_state
from cnnsim.accuracy.linear.system import linear_system
from cnnsim.backends.reference.drive import control
from cnnsim.library.catalogue import run_example
from cnnsim.task import make_task
from tests.benchmarks.accuracy.library_signs import large
from tests.benchmarks.accuracy.random_cases import case


@pytest.mark.parametrize("seed", [300019, 300216, 300315, 300430, 301071, 320341])
def test_two_runs_that_pass_a_ridge_on_its_wrong_side_are_not_believed(seed: int) -> None:
    one = case(seed)
    for accuracy in (1e-1, 1e-2):
        found = run_transient(**one.given, accuracy=accuracy, dtype="float64")
        assert np.abs(found.x - one.exact).max() <= accuracy, found.how


def test_runs_are_held_against_each_other_on_their_way() -> None:
    one = case(300315)  # its cells end alike by both steps, on the wrong side
    task = make_task(**one.given)
    steps = CorrectedSteps(task.plan, (task.state, task.input, task.bias, task.mask))
    coarse, none = steps.path(8), steps.path(0)
    before, _ = steps.taken(task.state, 8, none, 1, coarse)
    end, apart = steps.taken(task.state, 24, coarse, 3, none)
    on_the_way = [np.clip(before, -1, 1), np.clip(end, -1, 1)]
    assert apart >= np.abs(on_the_way[0] - on_the_way[1]).max() - 1e-6
    assert steps.taken(task.state, 8, coarse, 1, none)[1] < 1e-6
    np.testing.assert_allclose(coarse[-1].reshape(-1)[steps._real], np.clip(before, -1, 1).ravel(), atol=1e-6)


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


def test_a_cell_in_flight_off_a_ridge_takes_a_third_run() -> None:
    one = case(900397)  # by steps of 0.79 and 0.263 it errs nearly alike, by 0.07 and 0.05
    found = run_transient(**one.given, accuracy=1e-2, dtype="float64")
    assert np.abs(found.x - one.exact).max() <= 1e-2, found.how


@pytest.mark.parametrize("seed", [500045, 500082])
def test_plain_runs_that_pass_a_ridge_on_its_wrong_side_are_not_believed(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cnnsim.accuracy.reach.CELLS", 0)  # plain runs first, as on grids that are large
    rng = np.random.default_rng(seed + 1)
    x = np.where(rng.random((40, 40)) < 0.5, 1.0, -1.0) if rng.random() < 0.3 else rng.uniform(-1, 1, (40, 40))
    given = case(seed).given | {"state": x, "input": x[::-1], "bias": rng.normal(size=x.shape) * 0.3}
    found, fine = run_transient(**given, accuracy="binary"), run_transient(**given, accuracy=1e-6)
    wrong = {tuple(cell) for cell in np.argwhere(np.sign(found.y) != np.sign(fine.y))}
    assert wrong <= {tuple(cell) for cell in found.undecided}, found.how


def test_ties_of_a_mirrored_picture_are_named_and_all_else_is_right() -> None:
    entry = library.load("halftone-5x5")
    example = large(entry.examples[0], 16)
    found = run_example(entry, example, accuracy="binary")
    named = np.zeros(found.y.shape, bool)
    named[tuple(found.undecided.T)] = True
    u, rng = example.input, np.random.default_rng(3)
    assert u is not None
    taps, free = found.plan.template.feedback_taps, np.ones(u.size, bool)
    system = linear_system(taps, u.shape, found.plan.boundary)
    system = system.with_planes(control(found.plan, u, u, None).ravel(), free)
    pushes = [np.zeros(u.size), *(1e-13 * rng.choice([-1.0, 1.0], (5, u.size)))]
    ends = np.array([exact_state(system, u.ravel() + push, 120.0) > 0 for push in pushes]).reshape(-1, *u.shape)
    decided = (ends == ends[0]).all(axis=0)
    assert named.sum() < named.size / 4
    assert not (((found.y > 0) != ends[0]) & decided & ~named).any()
