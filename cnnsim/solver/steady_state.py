"""Steady states to an accuracy: one run where there is a single rest, else two runs that must end alike."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.network.boundary import correlate
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import EULER
from cnnsim.solver.problem import Solution, TransientProblem
from cnnsim.solver.spectrum import is_definite
from cnnsim.solver.step_refinement import by_steps, decide_signs, longest_step, refine
from cnnsim.solver.tolerance import Tolerance
from cnnsim.solver.verify_settled import verify_settled
from cnnsim.support import Array, Flags

_NEAR_THE_LIMIT = 0.75
_NEAR = 2e-6
"""Distance to the rest at which signs of small outputs are decided."""
_PERTURBATION = 100
"""Roundings by which the start of the first run is changed, so that cells which they decide end differently."""


def to_rest(problem: TransientProblem, where: Backend, tolerance: Tolerance) -> Solution:
    """Return the steady state of a transient, and the cells that no step decides.

    Two runs by different steps must agree; where they do not, step refinement follows the transient itself. Signs of
    saturated cells are compared with a run by accurate steps, as the errors of plain steps may favour one pattern.
    """
    plan, scheme = problem.plan, problem.plan.scheme or EULER
    if (once := _single_step(problem)) is not None:
        step, why = once
        found = _settle(problem, where, tolerance, by_steps(plan, EULER, step) if step else plan)
        return replace(found, how=f"{why}; {found.how}")
    last = _settle(problem, where, tolerance, plan)
    saturated = problem.free(np.abs(last.x) >= 1).any()  # else the rest is that of a linear system
    if last.settled and tolerance.signs and saturated and not problem.timed:
        return _signs(problem, where, tolerance, last)
    longer = plan.step * 2 <= _NEAR_THE_LIMIT * longest_step(plan, scheme)
    first = _settle(
        problem, where, tolerance, by_steps(plan, scheme, plan.step * (2.0 if longer else 0.5)),
        problem.perturbed(where, _PERTURBATION),
    )  # fmt: skip
    if not (first.settled and last.settled):
        return last if first.settled else first
    apart = np.abs(plan.output(last.x) - plan.output(first.x))
    apart = apart[problem.free(np.ones(apart.shape, bool))].max(initial=0.0)
    alike = np.array_equal(last.x > 0, first.x > 0) if tolerance.signs else apart <= tolerance.error
    if alike:
        how = f"steps of {last.plan.step:g} and {first.plan.step:g} lead to one end; {last.how}"
        last = replace(last, error=max(last.error, 0.0 if tolerance.signs else float(apart)), how=how)
        return _signs(problem, where, tolerance, last) if saturated and not problem.timed else last
    return _refined(problem, where, tolerance, max(first.t, last.t))


def _signs(problem: TransientProblem, where: Backend, tolerance: Tolerance, last: Solution) -> Solution:
    """Return the rest of a plain run if accurate steps confirm its signs (a second plain run may share its errors)."""
    path = decide_signs(_until(problem, last.t), where, last.x > 0)
    if np.array_equal(path.x > 0, last.x > 0) and not path.undecided.any():
        return replace(last, how=f"steps of {last.plan.step:g} and {path.how} lead to one end; {last.how}")
    return _continued(problem, where, tolerance, path)


def _refined(problem: TransientProblem, where: Backend, tolerance: Tolerance, time: float) -> Solution:
    """Return the rest to which step refinement leads, where two plain runs end differently."""
    path = refine(_until(problem, time), where, replace(tolerance, signs=True), torn=True)
    return _continued(problem, where, tolerance, path)


def _until(problem: TransientProblem, time: float) -> TransientProblem:
    """Return the transient until a time, rounded up to whole steps of the plan."""
    step = problem.plan.step
    time = max(1, math.ceil(min(time, problem.plan.limit) / step)) * step
    return replace(problem, plan=replace(problem.plan, duration=time))


def _continued(problem: TransientProblem, where: Backend, tolerance: Tolerance, path: Solution) -> Solution:
    """Return the rest to which an accurate run leads; undecided as well are signs that change after its end."""
    found = _settle(problem, where, tolerance, problem.plan, path.x.astype(where.dtype))
    undecided = path.undecided | found.undecided | ((path.x > 0) != (found.x > 0))
    how = f"plain runs alone do not decide; {path.how}; {found.how}"
    if undecided.any():
        how = f"{int(undecided.sum())} cells end differently by the smallest perturbation: {how}"
    return replace(found, t=max(path.t, found.t), undecided=undecided, how=how)


def _single_step(problem: TransientProblem) -> tuple[float, str] | None:
    """Return the step (0: the plan's own) with which one run is enough, and why; None if two runs are needed."""
    plan, (state, u, bias, mask) = problem.plan, problem.planes
    if plan.method != "stepped":
        return None
    template = plan.template
    if (template.A >= 0).all() and _is_monotone(plan, state, control(plan, state, u, bias), mask):
        return (1.0 if template.self_feedback >= 1 else 0.5), "no output changes direction, so every step leads there"
    if is_definite(template.feedback_taps, plan.boundary, decay=1e-9):
        return 0.0, "there is one rest"
    return None


def _is_monotone(plan: Plan, x: Array, drive: Array, mask: Flags | None) -> bool:
    """Return whether all outputs of a template with A >= 0 begin to fall, or all to rise, or stay as they are.

    None of them then changes its direction, and Euler's steps of h <= 1, which are monotone as well, end where the
    flow does (Hirsch and Smith, "Monotone Dynamical Systems", 2005, theorems 3.1 and 5.5). ``drive`` is B*u + z + bias.
    """
    rate = correlate(x.clip(-1, 1), plan.template.feedback_taps, plan.boundary, plan.boundary.y, drive.copy()) - x
    rate = rate if mask is None else np.where(mask, 0, rate)
    return bool(((rate <= 0) | (x >= 1)).all() or ((rate >= 0) | (x <= -1)).all())


def _settle(
    problem: TransientProblem, where: Backend, tolerance: Tolerance, plan: Plan, state: Array | None = None
) -> Solution:
    """Run once to the rest; where signs count, small outputs are solved for more accurately."""
    outcome = problem.start(where, plan, state)
    if not outcome.settled:
        x = where.read(outcome.x)
        return Solution(x, outcome.t, False, outcome.rate, math.inf, np.ones(x.shape, bool), plan, "not settled")
    planes = _loaded(where, *problem.planes[1:])
    for distance in (tolerance.error / 2, _NEAR):
        outcome, ending = verify_settled(where, plan, outcome, *planes, distance)
        x = where.read(outcome.x) if ending.x is None else ending.x
        error = max(ending.distance, float(np.finfo(where.dtype).eps))
        near = np.abs(x) <= error
        if not (tolerance.signs and outcome.settled and near.any()):
            break
    undecided = ending.undecided if ending.undecided.size == x.size else np.zeros(x.shape, bool)
    undecided = undecided | (near & (x != 0)) if tolerance.signs else undecided  # an exact 0 has no sign
    return Solution(x, outcome.t, outcome.settled, outcome.rate, error, undecided, plan, ending.how)


def _loaded(where: Backend, u: Array | None, bias: Array | None, mask: Any) -> tuple[Any, Any, Any]:
    planes = [None if plane is None else where.load(plane, "lam") for plane in (u, bias)]
    return planes[0], planes[1], None if mask is None else where.load(mask, "llm")
