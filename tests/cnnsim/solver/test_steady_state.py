"""Steady states to an accuracy: monotone transients take one run, others two, which must agree."""

from typing import Any

import numpy as np

from cnnsim import Template, fixed, library, run, run_transient
from cnnsim.network import ZERO_FLUX


def test_one_run_by_long_steps_ends_as_short_steps_do() -> None:
    picture = np.where(np.random.default_rng(5).random((30, 40)) < 0.4, 1.0, -1.0)
    for name in ("hole-filler", "shadow-left"):
        fast = run(name, picture, accuracy="binary")
        assert "every step leads there" in fast.how
        assert fast.plan.step >= 0.5
        assert np.array_equal(fast.y > 0, run(name, picture, step=0.02).y > 0)
        assert not len(fast.undecided)


def test_a_start_from_which_outputs_go_both_ways_takes_two_runs() -> None:
    x = np.random.default_rng(6).uniform(-1, 1, (9, 9))
    pulls = Template([[0, 0.3, 0], [0.3, 2, 0.3], [0, 0.3, 0]])
    assert "every step" not in run_transient(pulls, state=x, accuracy="binary", boundary=fixed(0)).how


def test_cells_on_a_ridge_are_named_in_float64() -> None:
    ridge = Template([[0, 0.3, 0], [0.3, 2, 0.3], [0, 0.3, 0]])
    x = np.random.default_rng(7).uniform(0.2, 1, (1, 9))
    x = np.concatenate([x, -x])  # the two rows are each other's mirror, and pull at each other
    found = run_transient(ridge, state=x, accuracy="binary", boundary=ZERO_FLUX, dtype="float64")
    wrong = np.argwhere(np.abs(found.y) < 0.99)
    assert {tuple(cell) for cell in wrong} <= {tuple(cell) for cell in found.undecided}
    zero = run_transient(ridge, state=0 * x, accuracy="binary", boundary=fixed(0), dtype="float64")
    assert len(zero.undecided) == x.size


def test_held_cells_leave_one_rest_whose_signs_one_run_finds() -> None:
    rng = np.random.default_rng(9)
    heat = library.load("laplace-solver").network
    x, mask = rng.uniform(-1, 1, (20, 24)), np.zeros((20, 24))
    mask[rng.random(mask.shape) < 0.05] = 1
    found = run_transient(heat, state=x, mask=mask, accuracy="binary", boundary=ZERO_FLUX)
    assert "steps of" in found.how
    other = np.where(mask > 0, x, -x)  # another start, the same held cells: the same rest
    fine = run_transient(heat, state=other, mask=mask, accuracy=1e-8, boundary=ZERO_FLUX)
    assert np.array_equal(found.y > 0, fine.y > 0)


def test_grey_rests_near_zero_are_seen_nearer_or_named() -> None:
    pulled = Template([[0, 0.2, 0], [0.2, 0, 0.2], [0, 0.2, 0]])
    bias = np.full((3, 3), 1e-4) * np.array([[1, -1, 1]])
    found = run_transient(pulled, state=np.zeros((3, 3)), bias=bias, accuracy="binary", boundary=fixed(0))
    fine = run_transient(pulled, state=np.zeros((3, 3)), bias=bias, accuracy=1e-9, boundary=fixed(0))
    named = {tuple(cell) for cell in found.undecided}
    assert {tuple(c) for c in np.argwhere((found.y > 0) != (fine.y > 0))} <= named
    assert found.error <= 1e-5


def test_a_pattern_that_plain_steps_choose_wrongly_is_found() -> None:
    """From a bias of 1e-3 two modes compete: Euler's steps of 0.1 and 0.2 both end in the wrong pattern."""
    template = Template([[0.0, -0.257, 0.499], [-0.055, 2.111, -0.055], [0.499, -0.257, 0.0]])
    given: dict[str, Any] = {"state": np.zeros((4, 3)), "bias": np.full((4, 3), 1e-3), "boundary": fixed(0)}
    fine = run_transient(template, **given, scheme="rk4", step=0.02, dtype="float64").y
    for step in (0.1, 0.2):
        assert not np.array_equal(run_transient(template, **given, scheme="euler", step=step).y, fine)
    assert np.abs(run_transient(template, **given, accuracy=1e-3).y - fine).max() <= 1e-3
