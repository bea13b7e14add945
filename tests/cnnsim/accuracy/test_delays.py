"""Delays to an accuracy, against the method of steps: order 2 reaches it in thousands of steps, order 1 in millions."""

import numpy as np
import pytest

from cnnsim import Template, Term, run_transient

DELAY, WEIGHT, START = 0.5, -0.9, 0.8


def truth(t: float) -> float:
    """Of dx/dt = -x + w x(t - d), x = x0 before 0, for d <= t <= 2 d: the first stretch, integrated once more."""
    first = WEIGHT * START + (1 - WEIGHT) * START * np.exp(-DELAY)
    left, rest, s = first - WEIGHT**2 * START, WEIGHT**2 * START, t - DELAY
    return float(rest + (left + WEIGHT * (1 - WEIGHT) * START * s) * np.exp(-s))


@pytest.mark.parametrize("accuracy", [1e-3, 1e-8])
def test_a_delayed_cell_is_as_near_the_truth_as_asked(accuracy: float) -> None:
    late = Template([[0.0]], terms=[Term([[WEIGHT]], "x_kl", delay=DELAY)])
    found = run_transient(late, state=np.full((2, 3), START), duration=1.0, accuracy=accuracy)
    assert np.abs(found.x - truth(1.0)).max() <= min(accuracy, 2 * found.error)
    assert found.plan.steps <= 20_000
