"""Cells of a network at rest that a tie decides: from starts pushed this way and that, by fine corrected steps."""

import math
from dataclasses import replace

import numpy as np

from cnnsim.accuracy.corrected import CorrectedSteps
from cnnsim.accuracy.repeatable import Repeatable
from cnnsim.accuracy.steps import longest_step
from cnnsim.planning.scheme import RK4
from cnnsim.planning.step import check_count
from cnnsim.support import Flags, Floats

_FINE = 0.7
"""The step of the run that counts, times the norm of A - I."""
_COARSE = 2.0
"""How much longer those of the others are, which only tell what a push changes."""
_PUSH = 1e-5
"""By which each cell of a start is pushed, over its size: about what the steps themselves miss."""
_FEWEST, _MOST = 4, 10
"""Runs: a tie between two pictures hides from n runs with probability 2^(1 - n)."""


def decided_by_ties(transient: Repeatable, duration: float) -> tuple[Floats, Flags, int]:
    """Return the state after a time by fine steps, the cells whose sign a push changes, and how many runs it took.

    Runs are made until two in a row find no cell more.
    """
    plan, state = replace(transient.plan, duration=duration), transient.planes[0]
    steps, norm = CorrectedSteps(plan, transient.planes), 1.0 + float(np.abs(plan.template.A).sum())
    number = math.ceil(duration / min(_FINE / norm, longest_step(plan, RK4)))
    check_count(duration, duration / number)
    rng, size = np.random.default_rng(0), _PUSH * np.maximum(np.abs(state), 1.0)
    if transient.planes[3] is not None:
        size[transient.planes[3]] = 0.0

    def pushed() -> Floats:
        start = state + size * rng.choice([-1.0, 1.0], state.shape)
        return steps.run(start, math.ceil(number / _COARSE))

    end = steps.run(state, number)
    unsure, quiet, runs = np.zeros(state.shape, bool), 0, 1
    while runs < _FEWEST or (quiet < 2 and runs < _MOST):
        more = ((pushed() > 0) != (end > 0)) & ~unsure
        quiet, runs, unsure = 0 if more.any() else quiet + 1, runs + 1, unsure | more
    return end, unsure, runs
