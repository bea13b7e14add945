"""Signs of outputs by the plan's own scheme and a longer step: where two runs leave no doubt, no other is needed."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cnnsim.accuracy.linear.spectral import is_definite
from cnnsim.accuracy.repeatable import Reached, Repeatable, largest
from cnnsim.accuracy.steps import by_steps, longest_step
from cnnsim.backends.base import Backend
from cnnsim.network import Frames
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.planning.step import is_whole_steps
from cnnsim.support import Array

APART = 0.4
"""How far apart the outputs of two runs may be on the way: where both took the wrong side of a ridge it is more."""
CELLS = 1 << 13
"""From here on a linear template is first tried so: on smaller grids corrected steps cost no more than the calls."""
_LONGER = 1.5
"""How much longer the other step must be, for two runs to differ by what a step costs."""
_CELL, _GRID = 3.0, 0.1
"""Of the difference of the two runs in a cell, and of the largest of all cells, by which an output must miss 0."""
_SPANS = 16
"""Of about a time constant, after each of which the runs are held against each other: it is early that a cell decides.
"""


def by_plain_signs(transient: Repeatable, where: Backend) -> Reached | None:
    """Return the end of a transient if its plan's step and one that is twice as long leave no sign in doubt.

    The error of the shorter step is about the difference of the two runs at order 1. Where twice the step is not
    stable, or does not divide delays and holding times, the other step is half as long, and counts.
    """
    plan = transient.plan
    if plan.scheme is None:
        return None
    other = by_steps(plan, plan.scheme, plan.step * _part(transient), timed=transient.timed)
    plans = [plan, other] if other.step < plan.step else [other, plan]
    starts = [transient.pushed(where, way) for way in (0.5, -0.5)]  # what rounding decides comes out both ways
    ways = (_states(transient, where, p, x) for p, x in zip(plans, starts, strict=True))
    for states in zip(*ways, strict=True):
        before, last = states
        if not largest(plan.output(last) - plan.output(before)) <= APART:
            return None
    y, apart = np.abs(plan.output(last)), np.abs(last - before)
    error = largest(apart) / (plans[0].step / plans[1].step - 1)
    if not math.isfinite(error) or transient.free(~(y > _CELL * apart + _GRID * error)).any():
        return None
    taken = ", ".join(f"{p.step:.3g}" for p in plans)
    how = f"{plan.scheme.name} by steps of {taken}; the two runs differ by less than a third of any output"
    nowhere = np.zeros(last.shape, bool)
    return Reached(last, float(plan.duration), False, math.nan, error, nowhere, plans[1], how)


def _part(transient: Repeatable) -> float:
    """Return the other step over the plan's: 2 if that can be."""
    plan = transient.plan
    assert plan.scheme is not None
    part = min(2.0, longest_step(plan, plan.scheme) / plan.step)
    if not transient.timed:
        return part if part >= _LONGER else 0.5
    assert plan.network is not None
    periods = [plane.period for plane in transient.planes if isinstance(plane, Frames)]
    times = (*delays_of(plan.network), *periods, float(plan.duration))
    return 2.0 if part == 2.0 and is_whole_steps(times, 2 * plan.step) else 0.5


def _never_parts(plan: Plan) -> bool:
    """Return whether two states of the network come nearer to each other, whatever they are: there are no ridges."""
    return plan.method == "stepped" and is_definite(plan.template.feedback_taps, plan.boundary)


def _states(transient: Repeatable, where: Backend, plan: Plan, state: Array) -> Iterator[Array]:
    """Yield the states on the way and at the end; delays and sequences know no state to go on from but the first.

    Where two states never part, the end alone tells.
    """
    duration = float(plan.duration)
    if transient.timed or duration <= 1 or _never_parts(plan):
        yield where.read(transient.start(where, plan, state).x)
        return
    spans = min(round(duration), _SPANS)
    for n in range(spans):
        span = duration / round(duration) if n + 1 < spans else duration - n * duration / round(duration)
        onward = by_steps(replace(plan, duration=span), plan.scheme, plan.step)  # type: ignore[arg-type]  # it has one
        state = where.read(transient.start(where, onward, state).x)
        yield state
