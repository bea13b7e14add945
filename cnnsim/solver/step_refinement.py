"""Step refinement: runs of one transient by shorter and shorter steps until two of them agree to the accuracy."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.network.weights import reach
from cnnsim.planning.general import delays_of
from cnnsim.planning.network_modes import step_bound
from cnnsim.planning.plan import Plan
from cnnsim.planning.savings import stepped_savings
from cnnsim.planning.scheme import HEUN, RK4, Scheme
from cnnsim.planning.stability import step_limit
from cnnsim.planning.step import check_count, divided
from cnnsim.solver.linear_system import linear_system
from cnnsim.solver.problem import Solution, TransientProblem, largest
from cnnsim.solver.tolerance import Tolerance
from cnnsim.support import Array

CORRECTED_CELLS = 1 << 14
"""Cells up to which one thread takes the corrected steps; on larger grids the backend is faster."""
MOST_RUNS, MOST_RUNS_FOR_SIGNS = 12, 6
_AIM = 0.5
"""Of the tolerance, that the error of the last run but one is to have."""
_LEAST_RATIO, _LARGEST_RATIO = 1.6, 6.0
"""How much shorter the steps of the next run are."""
_LOWEST_ORDER, _USUAL_ORDER, _HIGHEST_ORDER = 1.0, 2.5, 4.0
"""Of plain steps: 4 without kinks, 2 with them, 1 where a term jumps."""
_TWO_RUNS = 1.5
"""Times their difference is the error of the first two runs, which may agree by chance."""
_ROUNDINGS = 4.0
"""By which the start of each run is changed, so that the difference of two runs has the growth of rounding errors."""

_STEP_ERROR, _MORE_RUNS = 1e-5, 4
"""Changes of the start, about the error of the last steps, and runs that find the cells whose signs depend on them."""
_STEP_OF_SIGNS = 1.4
"""Step of the first run for signs, times 1 + sum|A|."""
_FEWEST_STARTS, _MOST_STARTS = 3, 12
"""Changed starts: of cells that turn together at random, n starts miss all with probability 2^-n."""
_STATES = 16
"""Of a corrected run, that are compared on the way."""
_APART = 0.4
"""Largest difference of two runs' outputs on the way: where both pass a separatrix on the wrong side it is more."""

Run = Callable[[Array, int], Array]
"""(state, steps) -> states (n, ...) on the way, the last one at the end of the transient."""


def refine(problem: TransientProblem, where: Backend, tolerance: Tolerance, *, torn: bool = False) -> Solution:
    """Solve a transient of a given duration by shorter and shorter steps, until two runs agree to the tolerance.

    The error of the last run is estimated as its largest difference from the one before, and no less than the estimate
    before predicts at one order more than usual, as two runs may agree by chance. Each run starts from a state changed
    by a few roundings, so that the difference also shows how they grow. With ``tolerance.signs`` the runs end when each
    output differs from 0 by more than its estimated error; ``torn``: further starts show which signs rounding decides.
    """
    plan, duration = problem.plan, float(problem.plan.duration)
    corrected = is_corrected(problem)
    scheme = HEUN if problem.timed and plan.network is not None and delays_of(plan.network) else RK4
    run = _corrected_run(problem) if corrected else _backend_run(problem, where, scheme)
    norm = 1.0 + float(np.abs(plan.template.A).sum())
    first = plan.step if problem.timed else min(longest_step(plan, scheme), 2.8 / norm if corrected else 0.8)
    whole = _STATES if corrected else 1  # steps are divided by
    counts = [whole * math.ceil(duration / first / whole - 1e-9)]
    before = run(problem.perturbed(where, _ROUNDINGS), counts[0])
    differences: list[float] = []
    error, ratio, done = math.inf, 2.0 if problem.timed else _LEAST_RATIO, False  # delays are whole steps
    while True:
        counts.append(whole * math.ceil(counts[-1] * ratio / whole))
        check_count(duration, duration / counts[-1])
        path, ratio = run(problem.perturbed(where, -_ROUNDINGS, len(counts)), counts[-1]), counts[-1] / counts[-2]
        end, difference = path[-1], np.abs(path[-1] - before[-1])
        together = largest(plan.output(path) - plan.output(before)) <= _APART
        differences.append(largest(difference))
        floor = _ROUNDINGS * float(np.finfo(where.dtype).eps) * max(1.0, largest(path))
        back = 3 if tolerance.signs else 4
        stalled = len(differences) >= back and differences[-1] > 0.5 * differences[-back]
        predicted = error / ratio ** (4 if corrected else 3) if len(counts) > 2 else differences[-1] * _TWO_RUNS
        error = max(floor, differences[-1], predicted)
        order = 3.0 if corrected else _order(differences, ratio)
        undecided = problem.free(~(np.abs(plan.output(end)) > 2 * difference + min(0.6 * error, tolerance.error)))
        done = together and error <= tolerance.error and not (tolerance.signs and undecided.any())
        most = MOST_RUNS_FOR_SIGNS if tolerance.signs else MOST_RUNS
        if done or stalled or len(counts) >= most or (error <= 2 * floor and not tolerance.signs):
            break
        aim = tolerance.error
        if tolerance.signs and undecided.any():
            aim = min(aim, max(float(np.abs(end)[undecided].min()), error / 16))
        ratio = _next_ratio(differences[-1], ratio, order, aim)
        ratio = 2.0 ** math.ceil(math.log2(ratio) - 1e-9) if problem.timed else ratio
        before = path
    if tolerance.signs and (torn or not done):  # near a separatrix the errors of the steps decide as well
        size = _ROUNDINGS if done else _STEP_ERROR / float(np.finfo(where.dtype).eps)
        for seed in range(_MORE_RUNS):
            other = run(problem.perturbed(where, size, 100 + seed), counts[1])[-1]
            undecided |= problem.free((plan.output(other) > 0) != (plan.output(end) > 0))
    name = f"{scheme.name} with corrected kinks" if corrected else scheme.name
    steps = ", ".join(f"{duration / n:.3g}" for n in counts)
    how = f"{name} by steps of {steps}; the last two runs differ by {differences[-1]:.2g}"
    how = how if done else f"{how}; {tolerance} was not reached"
    last = by_steps(plan, scheme, duration / counts[-1], timed=problem.timed)
    return Solution(end, duration, False, math.nan, error, undecided, last, how)


def decide_signs(problem: TransientProblem, where: Backend, expected: Array) -> Solution:
    """Solve a transient for its signs. A sign is undecided if a small change of the start or a longer step turns it.

    The changes are about the errors of the steps. If the first changed start leads to the ``expected`` signs, that run
    is the solution; else a run by half the step is, and further starts follow until two in a row turn no other cell.
    """
    plan, duration, corrected = problem.plan, float(problem.plan.duration), is_corrected(problem)
    run = _corrected_run(problem) if corrected else _backend_run(problem, where, RK4)
    whole, size = _STATES if corrected else 1, _STEP_ERROR / float(np.finfo(where.dtype).eps)
    step = min(_STEP_OF_SIGNS / (1.0 + float(np.abs(plan.template.A).sum())), longest_step(plan, RK4))
    count = whole * math.ceil(duration / step / whole)
    check_count(duration, duration / (2 * count))
    others = [run(problem.perturbed(where, size, 0), count)[-1]]
    end, undecided, unchanged = others[0], np.zeros(others[0].shape, bool), 0
    if problem.free((end > 0) != expected).any():
        end, count = run(problem.planes[0], 2 * count)[-1], 2 * count
        undecided = problem.free((others[0] > 0) != (end > 0))
        while len(others) < _FEWEST_STARTS or (unchanged < 2 and len(others) < _MOST_STARTS):
            others.append(run(problem.perturbed(where, size, len(others)), count // 2)[-1])
            turned = problem.free((others[-1] > 0) != (end > 0)) & ~undecided
            undecided, unchanged = undecided | turned, 0 if turned.any() else unchanged + 1
        if unchanged < 2:  # more starts would turn more cells
            undecided |= problem.free((end > 0) != expected)
    error = max(largest(other - end) for other in others)
    name = "rk4 with corrected kinks" if corrected else "rk4"
    how = f"{name} by steps of {duration / count:.3g}, runs from changed starts: {len(others)}"
    last = by_steps(plan, RK4, duration / count)
    return Solution(end, duration, False, math.nan, error, undecided, last, how)


def _order(differences: list[float], ratio: float) -> float:
    """Return the order that the last two differences show, the usual one where there is one."""
    if len(differences) < 2:
        return _USUAL_ORDER
    if not 0 < differences[-1] < differences[-2] < math.inf:
        return 2.0
    return float(np.clip(math.log(differences[-2] / differences[-1]) / math.log(ratio), _LOWEST_ORDER, _HIGHEST_ORDER))


def _next_ratio(difference: float, ratio: float, order: float, aim: float) -> float:
    """Return the ratio of the last step to the next one, so that its run or the one after it is within the aim."""
    predicted = difference / (ratio**order - 1)
    needed = (predicted / (_AIM * aim)) ** (1 / order) if aim > 0 and math.isfinite(predicted) else math.inf
    return min(max(needed, _LEAST_RATIO), _LARGEST_RATIO)


def is_correctable(plan: Plan, shape: tuple[int, ...]) -> bool:
    """Return whether a plan is of a linear template on one grid of this shape, which is not large."""
    linear = plan.method == "stepped" and plan.cell == "chua-yang" and not plan.template.control_terms
    return linear and len(shape) == 2 and math.prod(shape) <= CORRECTED_CELLS


def is_corrected(problem: TransientProblem) -> bool:
    """Return whether a transient is run by corrected steps: correctable, with a constant input and bias."""
    state, u, bias, _ = problem.planes
    constant = all(plane is None or isinstance(plane, np.ndarray) for plane in (u, bias))
    return constant and is_correctable(problem.plan, state.shape)


def _corrected_run(problem: TransientProblem) -> Run:
    from cnnsim.solver.corrected_rk4 import corrected_steps  # numba is slow to import

    plan, (state, u, bias, mask) = problem.plan, problem.planes
    system = linear_system(plan.template.feedback_taps, plan.shape, plan.boundary)
    drive = system.drive + control(plan, state.astype(np.float64), u, bias).ravel()
    cells = np.stack([drive, np.ones(drive.size) if mask is None else 1.0 - mask.ravel()])
    matrix, duration = (system.matrix.indptr, system.matrix.indices, system.matrix.data), float(plan.duration)
    taps = plan.template.feedback_taps
    inside = np.zeros(plan.shape, bool)
    r = reach((k, l) for k, l, _ in taps)
    inside[r : plan.shape[0] - r, r : plan.shape[1] - r] = True
    offsets = np.array([k * plan.shape[1] + l for k, l, _ in taps], np.int64)
    shifted = offsets, np.array([weight for *_, weight in taps], float), np.flatnonzero(~inside)

    def run(start: Array, count: int) -> Array:
        x = start.astype(np.float64).ravel()
        states = np.empty((_STATES, *start.shape))
        for n in range(_STATES):
            corrected_steps(matrix, shifted, cells, x, duration / count, count // _STATES)
            states[n] = x.reshape(start.shape)
        return states

    return run


def _backend_run(problem: TransientProblem, where: Backend, scheme: Scheme) -> Run:
    plans: list[Any] = []

    def run(start: Array, count: int) -> Array:
        step = float(problem.plan.duration) / count
        if plans and len(scheme.b) > 1:  # the savings of several stages do not depend on the step
            plans.append(replace(plans[-1], step=step))
        else:
            plans.append(by_steps(problem.plan, scheme, step, timed=problem.timed))
        return where.read(problem.start(where, plans[-1], start).x)[None]

    return run


def by_steps(plan: Plan, scheme: Scheme, step: float, *, timed: bool = False) -> Plan:
    """Return the plan with a scheme and a step, made to fit the duration; ``timed``: the step divides all times."""
    h = step if timed else divided(plan.duration, step)
    check_count(plan.limit if plan.duration == "settled" else plan.duration, h)
    if plan.method == "general":
        return replace(plan, scheme=scheme, step=h)
    settles = plan.duration == "settled"
    steps = max(1, round(1 / h)) if settles else math.ceil(float(plan.duration) / h - 1e-9)
    applicable = {name for name, _ in stepped_savings(plan.template, scheme, h, plan.cell, steps, settles=settles)}
    return replace(plan, method="stepped", scheme=scheme, step=h, savings=plan.savings & applicable)


def longest_step(plan: Plan, scheme: Scheme) -> float:
    """Return a step with which the scheme is stable."""
    if plan.method == "general":
        assert plan.network is not None
        return 0.95 * step_bound(plan.network, plan.characteristic, plan.duration, scheme)
    return 0.95 * step_limit(plan.template, plan.boundary, plan.duration, scheme)
