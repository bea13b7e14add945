"""A transient to its rest, by two steps that must lead to one end where there may be several."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.accuracy.at_rest import seen_to_the_end
from cnnsim.accuracy.corrected import is_corrected
from cnnsim.accuracy.linear.spectral import is_definite, only_constants_last
from cnnsim.accuracy.monotone import goes_one_way, is_cooperative
from cnnsim.accuracy.repeatable import Reached, Repeatable
from cnnsim.accuracy.steps import by_steps, longest_step
from cnnsim.accuracy.ties import decided_by_ties
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import EULER
from cnnsim.support import Array, Flags

_PARTS = (2.0, 1.0, 0.5, 0.125)
"""Of the plan's step: two runs that agree are enough."""
_NEAR_THE_LIMIT = 0.75
_NEAR = 2e-6
"""How far from the one rest that there is signs are looked at."""
_PUSH = 100
"""Roundings by which the start of every other run is pushed, so that what they decide comes out differently."""


def to_rest(transient: Repeatable, where: Backend, wanted: Wanted) -> Reached:
    """Return the rest of a transient, with the cells that no step decides."""
    plan = transient.plan
    if (once := _one_step(transient)) is not None:
        step, why = once
        again = by_steps(plan, EULER, step) if step else plan
        reached = _ended(transient, where, wanted, again)
        # a grey rest is seen again, so near that few signs are open
        if wanted.signs and (np.abs(reached.x) <= reached.error).any():
            reached = _ended(transient, where, replace(wanted, error=_NEAR), again, state=reached.x)
            near = (np.abs(reached.x) <= reached.error) & (reached.x != 0)  # 0 in all digits has no sign
            reached = replace(reached, undecided=reached.undecided | near)
        return replace(reached, how=f"{why}; {reached.how}") if reached.settled else reached
    scheme = plan.scheme or EULER
    parts = [part for part in _PARTS if part <= 1 or plan.step * part <= _NEAR_THE_LIMIT * longest_step(plan, scheme)]
    ends: list[Reached] = []
    for number, part in enumerate(parts):
        again = plan if part == 1.0 else by_steps(plan, scheme, plan.step * part)
        ends.append(_ended(transient, where, wanted, again, 0 if number % 2 else _PUSH))
        if not ends[-1].settled:
            return ends[-1]
        if len(ends) > 1 and _alike(ends[-2], ends[-1], wanted):
            break
        if len(ends) > 1 and wanted.signs and is_corrected(transient):
            return _tied(transient, where, wanted, max(end.t for end in ends))
    before, last = ends[-2:]
    y, other = (end.plan.output(end.x) for end in (last, before))
    apart = np.abs(y - other)
    unsure = (np.sign(y) != np.sign(other)) & (apart > wanted.error)
    if last.undecided.size == unsure.size:
        unsure |= last.undecided
    same = float(apart[~unsure].max(initial=0.0))
    how = f"steps of {last.plan.step:g} and {before.plan.step:g} lead to one end; {last.how}"
    if unsure.any():
        how = f"{int(unsure.sum())} cells end elsewhere with another step or push, or on a ridge; {last.how}"
    return replace(last, error=max(last.error, same / 2), undecided=unsure, how=how)


def _tied(transient: Repeatable, where: Backend, wanted: Wanted, time: float) -> Reached:
    """Return the rest that fine steps lead to, where two plain runs do not agree on its signs."""
    x, unsure, runs = decided_by_ties(transient, time)
    reached = _ended(transient, where, wanted, transient.plan, state=x)
    how = f"two plain runs differ; rk4 with its kinks corrected decides, {runs} runs from pushed starts; {reached.how}"
    if unsure.any():
        how = f"{int(unsure.sum())} cells end elsewhere by the smallest push: {how}"
    unsure = unsure | reached.undecided | ((x > 0) != (reached.x > 0))
    return replace(reached, t=max(time, reached.t), undecided=unsure, how=how)


def _one_step(transient: Repeatable) -> tuple[float, str] | None:
    """Return the step (0: the plan's own) with which one run is enough, and why; None if it takes two."""
    plan, (state, u, bias, mask) = transient.plan, transient.planes
    if plan.method != "stepped":
        return None
    template = plan.template
    if is_cooperative(plan) and goes_one_way(plan, state, control(plan, state, u, bias), mask):
        return (1.0 if template.self_feedback >= 1 else 0.5), "no output ever turns round, so every step leads there"
    if is_definite(template.feedback_taps, plan.boundary, decay=1e-9):
        return 0.0, "there is one rest"
    if _is_pinned(plan, mask):
        return 0.0, "there is one rest that holds what is held"
    return None


def _is_pinned(plan: Plan, mask: Flags | None) -> bool:
    """Return whether I - A is definite among the free cells, as held ones or those beyond the edge pin all waves."""
    taps, boundary = plan.template.feedback_taps, plan.boundary
    if not is_definite(taps, boundary):
        return False
    if boundary.kind == "fixed":  # among finitely many cells no wave is nothing but one that lasts
        return True
    held = mask is not None and bool(mask.reshape(-1, *plan.shape).any(axis=(1, 2)).all())
    return held and only_constants_last(taps, plan.shape, boundary)


def _ended(
    transient: Repeatable, where: Backend, wanted: Wanted, plan: Plan, push: int = 0, state: Array | None = None
) -> Reached:
    """Run once until it settles, and see it to its end."""
    outcome = transient.start(where, plan, transient.pushed(where, push) if push else state)
    if not outcome.settled:
        x = where.read(outcome.x)
        return Reached(x, outcome.t, False, outcome.rate, math.inf, np.ones(x.shape, bool), plan, "not settled")
    outcome, ending = seen_to_the_end(where, plan, outcome, *_loaded(where, *transient.planes[1:]), wanted.error / 2)
    x = where.read(outcome.x) if ending.x is None else ending.x
    undecided = ending.undecided if ending.undecided.size == x.size else np.zeros(x.shape, bool)
    error = max(ending.distance, float(np.finfo(where.dtype).eps))
    return Reached(x, outcome.t, outcome.settled, outcome.rate, error, undecided, plan, ending.how)


def _alike(before: Reached, last: Reached, wanted: Wanted) -> bool:
    y, other = (end.plan.output(end.x) for end in (last, before))
    if wanted.signs:
        return bool(np.array_equal(y > 0, other > 0))
    return bool(np.abs(y - other).max() <= wanted.error)


def _loaded(where: Backend, u: Array | None, bias: Array | None, mask: Any) -> tuple[Any, Any, Any]:
    planes = [None if plane is None else where.load(plane, "lam") for plane in (u, bias)]
    return planes[0], planes[1], None if mask is None else where.load(mask, "llm")
