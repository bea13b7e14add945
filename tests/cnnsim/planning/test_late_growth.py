"""Patterns that grow from grey states: what Euler's steps lose of them is said, and is what a run loses."""

import numpy as np
import pytest

from cnnsim import PERIODIC, Template, explain, run_transient
from cnnsim.planning.stability import late_growth

STRIPES = Template([[0, -0.5, 0], [0.75, 1.2, 0.75], [0, -0.5, 0]])
"""Grows fastest where rows are even and their signs alternate: 1.2 + 1.5 + 1 - 1 a time constant."""


def test_growth_is_that_of_a_pattern_as_it_grows() -> None:
    x = np.where(np.arange(8) % 2, 1e-9, -1e-9)[:, None] * np.ones(8)
    rate, lost = late_growth(STRIPES, 0.1)
    grown = run_transient(STRIPES, state=x, boundary=PERIODIC, duration=2.0, step=0.1, scheme="euler", dtype="float64")
    assert rate == pytest.approx(2.7)
    assert np.log(np.abs(grown.x).max() / 1e-9) == pytest.approx(2 * rate * (1 - lost), rel=1e-9)


def test_explain_says_it_of_grey_states_and_of_steps_that_lose_much() -> None:
    grey, black = np.linspace(-0.5, 0.5, 64).reshape(8, 8), np.ones((8, 8))
    assert "grow by up to 2.7 a time constant, of which steps of 0.1 lose 11%" in explain(STRIPES, grey).growth
    assert not explain(STRIPES, black).growth
    assert not explain(STRIPES, grey, step=0.01).growth
    assert not explain(STRIPES, grey, scheme="rk4").growth
    assert not explain(Template([[3.0]]), grey, step=0.1).growth, "each cell keeps its sign"
    assert not explain(Template([[0.1, 0.1, 0.1], [0.1, 0.0, 0.1], [0.1, 0.1, 0.1]]), grey).growth
