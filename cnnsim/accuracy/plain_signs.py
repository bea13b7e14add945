"""Signs of outputs by the plan's own scheme and a longer step: where two runs leave no doubt, no other is needed."""

import math

import numpy as np

from cnnsim.accuracy.repeatable import Reached, Repeatable, largest
from cnnsim.accuracy.steps import by_steps, longest_step
from cnnsim.backends.base import Backend

_LONGER = 1.5
"""How much longer the other step must be, for two runs to differ by what a step costs."""
_CELL, _GRID = 3.0, 0.1
"""Of the difference of the two runs in a cell, and of the largest of all cells, by which an output must miss 0."""


def by_plain_signs(transient: Repeatable, where: Backend) -> Reached | None:
    """Return the end of a transient if its plan's step and one that is twice as long leave no sign in doubt.

    The error of the shorter step is about the difference of the two runs at order 1. Where delays and sequences fix the
    steps, or twice the step is not stable, the other step is half as long, and counts.
    """
    plan = transient.plan
    if plan.scheme is None:
        return None
    part = 0.5 if transient.timed else min(2.0, longest_step(plan, plan.scheme) / plan.step)
    other = by_steps(plan, plan.scheme, plan.step * (part if part >= _LONGER else 0.5), timed=transient.timed)
    plans = [plan, other] if other.step < plan.step else [other, plan]
    starts = [transient.pushed(where, way) for way in (0.5, -0.5)]  # what rounding decides comes out both ways
    before, last = (where.read(transient.start(where, p, x).x) for p, x in zip(plans, starts, strict=True))
    y, apart = np.abs(plan.output(last)), np.abs(last - before)
    error = largest(apart) / (plans[0].step / plans[1].step - 1)
    if not math.isfinite(error) or not (y > _CELL * apart + _GRID * error).all():
        return None
    taken = ", ".join(f"{p.step:.3g}" for p in plans)
    how = f"{plan.scheme.name} by steps of {taken}; the two runs differ by less than a third of any output"
    nowhere = np.zeros(last.shape, bool)
    return Reached(last, float(plan.duration), False, math.nan, error, nowhere, plans[1], how)
