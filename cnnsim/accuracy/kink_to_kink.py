"""A transient from kink to kink, where that costs less than steps that are short enough."""

import math
from functools import lru_cache

import numpy as np

from cnnsim.accuracy.corrected import first_step
from cnnsim.accuracy.linear.exact_flow import exact_flow
from cnnsim.accuracy.linear.system import LinearSystem, linear_system
from cnnsim.accuracy.repeatable import Reached, Repeatable
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.reference.drive import control
from cnnsim.planning.plan import Plan
from cnnsim.support import Floats

MOST_CELLS = 2_000
_CALLS = 5e-4
"""Seconds that the calls of three runs take, however small the grid."""
_STEP, _STEP_OF_A_CELL = 4e-7, 2e-8
"""Seconds of an rk4 step, and for each cell."""
_RUNS = 4.0
"""Steps of all runs over those of the first."""
_SIZE = 0.1
"""Of the error of rk4 where kinks decide, over (step x norm of A - I)^2: a guess, from which the cost is guessed."""
_SERIES, _SERIES_OF_A_CELL = 5e-6, 4e-7
"""Seconds of a series, and for each cell."""
_ROUNDING = 4e-15
_system = lru_cache(maxsize=16)(linear_system)


def affordable_kinks(plan: Plan, wanted: Wanted) -> int:
    """Return how many kinks cost no more than rk4 by steps as short as the accuracy needs; 0 where there is no flow.

    Only the transient of one linear template on one grid that is not large has one.
    """
    cells = math.prod(plan.shape)
    if plan.method != "stepped" or cells > MOST_CELLS:
        return 0
    times = float(plan.duration) * (1.0 + float(np.abs(plan.template.A).sum()))
    if plan.cell == "chua-yang":
        by_steps = _RUNS * times / first_step(wanted) * (_STEP + cells * _STEP_OF_A_CELL)
    else:
        by_steps = _CALLS + times * math.sqrt(_SIZE / wanted.error) * cells * _STEP_OF_A_CELL
    return int(by_steps / (_SERIES + cells * _SERIES_OF_A_CELL) - times / 2)


def _expected(system: LinearSystem, x: Floats) -> int:
    """Return how many cells are saturated now, or will be if their drives stay as they are, but not both."""
    drive = system.matrix @ x.clip(-1, 1) + system.drive
    now, then = (np.sign(v) * (np.abs(v) >= 1) for v in (x, drive))
    return int((now != then)[system.free].sum())


def by_kinks(transient: Repeatable, most: int) -> Reached | None:
    """Return the end of a transient by the exact flow, None if it has more kinks.

    The error is how far the flow moves what rounding changes.
    """
    plan, (state, u, bias, mask) = transient.plan, transient.planes
    system = _system(plan.template.feedback_taps, plan.shape, plan.boundary, limited=plan.cell == "full-range")
    free = np.ones(state.size, bool) if mask is None else ~mask.ravel()
    state = state.astype(np.float64)
    drive = control(plan, state, u if u is None else u.astype(np.float64), bias)
    system, duration = system.with_planes(drive.ravel(), free), float(plan.duration)
    push = _ROUNDING * np.random.default_rng(0).choice([-1.0, 1.0], state.size) * np.maximum(np.abs(state.ravel()), 1)
    if _expected(system, state.ravel()) > most:
        return None
    found = exact_flow(system, state.ravel(), np.where(free, push, 0.0), duration, 2 * most)
    if found.left:
        return None
    error = max(5 * _ROUNDING, float(np.abs(found.push).max()))
    x, moved = found.x.reshape(state.shape), found.push.reshape(state.shape)
    how = f"from kink to kink by the matrix exponential ({found.kinks} kinks); its error is how far rounding moves it"
    unsure = np.abs(x) <= error + np.abs(moved)
    return Reached(x, duration, False, math.nan, error, unsure, plan, how)
