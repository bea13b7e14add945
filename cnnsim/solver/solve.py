"""Solution of a transient to an accuracy: closed form, solved steady state, or step refinement."""

from dataclasses import replace

import numpy as np

from cnnsim.backends import in_float64
from cnnsim.backends.base import Backend, check_finite
from cnnsim.planning.plan import Plan
from cnnsim.recording import check_times
from cnnsim.solver.closed_form import by_closed_form, edge_jumps
from cnnsim.solver.problem import Solution, TransientProblem, largest
from cnnsim.solver.steady_state import to_rest
from cnnsim.solver.step_refinement import is_correctable, refine
from cnnsim.solver.tolerance import Tolerance
from cnnsim.support import Floats, InputError
from cnnsim.support.memory import LARGE
from cnnsim.trajectories import CellIndex, Trajectory


def solve(problem: TransientProblem, backend: Backend, tolerance: Tolerance) -> Solution:
    """Solve a transient to an accuracy on a backend, in float64 where float32 cannot give it.

    Raises:
        InputError: float64 is needed and the device has none; a state is not finite.
    """
    where, note, plan = backend, "", problem.plan
    if tolerance.dtype == "float64" and backend.dtype != "float64":
        where, note = in_float64(backend), f"; in float64, as float32 cannot give {tolerance}"
        if where.dtype != "float64":
            raise InputError(f"accuracy {tolerance}: the device has no float64, and float32 cannot give it")
    jumps = edge_jumps(plan, problem.planes[0].shape, problem.planes[1], where.dtype)
    if jumps is not None and (finer := in_float64(backend)).dtype != where.dtype:
        where, note = finer, "; in float64, as inputs lie at the edge of a step of a table"
        jumps = edge_jumps(plan, problem.planes[0].shape, problem.planes[1], where.dtype)
    if plan.cell == "discrete-time":
        found = problem.once(where, "discrete time has no error")
    elif plan.method == "closed form":
        found = by_closed_form(problem, where, jumps)
    elif plan.duration == "settled":
        found = to_rest(problem, where, tolerance)
    elif not plan.duration:
        found = problem.once(where, "the duration is 0")
    else:
        exact = in_float64(where) if problem.planes[0].size < LARGE else where  # rounding errors may grow
        found = refine(problem, exact, tolerance)
        rounding = float(np.finfo(where.dtype).eps) * max(1.0, largest(found.x))
        found = replace(found, x=found.x.astype(where.dtype, copy=False), error=max(found.error, rounding))
    if jumps is not None:
        edge = found.undecided & (jumps > 0) if plan.method == "closed form" else problem.free(jumps > 0)
        found = replace(found, undecided=found.undecided | edge)
        note += f"; at {int(edge.sum())} cells the last digit of the input decides"
    check_finite(found.x, found.t)  # float32 may not hold what float64 finds
    how = f"accuracy {tolerance}: {found.how}{note}"
    return replace(found, undecided=problem.free(found.undecided), how=how)


def solve_at(problem: TransientProblem, where: Backend, tolerance: Tolerance, t: float) -> tuple[float, Solution]:
    """Return a time and the solution at it, independent of the transient's duration.

    The time is ``t``, or the nearest step where delays, sequences or discrete time allow whole steps only.
    """
    plan = problem.plan
    if problem.timed or plan.cell == "discrete-time":
        t = round(t / plan.step) * plan.step
    return t, solve(replace(problem, plan=replace(plan, duration=t)), where, tolerance)


def record_solutions(
    problem: TransientProblem, where: Backend, tolerance: Tolerance, record: tuple[CellIndex, ...] | Floats
) -> tuple[Trajectory, float]:
    """Return the states at times (from `parse_record`), each solved separately, and the largest error estimate.

    Raises:
        InputError: cells; a time after the end of a fixed duration.
    """
    if not isinstance(record, np.ndarray):
        raise InputError(
            "record: cells are recorded at every step, but the runs of an accuracy differ in their steps; times, or "
            "cells with a scheme and a step, wanted"
        )
    check_times(problem.plan, record)
    found = dict(solve_at(problem, where, tolerance, float(t)) for t in record)
    x = np.array([one.x for one in found.values()])
    return Trajectory(np.array(list(found)), x, problem.plan.output(x)), max(one.error for one in found.values())


def decision(plan: Plan, tolerance: Tolerance, shape: tuple[int, ...]) -> tuple[str, str]:
    """Return how a transient of this shape is solved to an accuracy, and why, as text for `explain`."""
    if plan.cell == "discrete-time" or plan.method == "closed form":
        why = "the plan's own method, which is exact"
    elif plan.duration == "settled":
        why = (
            "one run where the theory knows a single rest, else two by different steps, which must end alike within "
            f"{tolerance} of the rest"
        )
    else:
        order = "with corrected kinks (order 3)" if is_correctable(plan, shape) else "(order 4, 2 where kinks occur)"
        why = f"rk4 {order} by shorter and shorter steps until two runs agree"
    return f"accuracy {tolerance}", f"{why}; {tolerance.dtype} or more"
