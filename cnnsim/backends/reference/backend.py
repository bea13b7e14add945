"""The reference backend: plain float64 NumPy, slow and obvious. It is the law the others are held to."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends.base import Memory, Outcome, check_finite
from cnnsim.backends.reference import terms as reference_general
from cnnsim.network.boundary import Boundary, pad
from cnnsim.network.cell import output, rate, uncoupled_state
from cnnsim.network.template import Tap
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.logic import truth_table
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support.errors import InputError
from cnnsim.support.types import Array


def correlate(plane: Array, taps: Sequence[Tap], boundary: Boundary, constant: float, start: Array) -> Array:
    """Return start + sum over the taps of weight * plane(row + k, col + l), added in the order of the taps."""
    total = start.copy()
    r = max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)
    around = pad(plane, r, boundary, constant)
    rows, cols = plane.shape[-2:]
    for k, l, weight in taps:
        total += weight * around[..., r + k : r + k + rows, r + l : r + l + cols]
    return total


class ReferenceBackend:
    """Planes are NumPy arrays, float64 for LAM and bool for LLM."""

    name = "reference"

    def __init__(self, dtype: DTypeLike | None = None) -> None:
        self.dtype = np.dtype(np.float64 if dtype is None else dtype)
        if self.dtype != np.float64:
            raise InputError(f"the reference backend computes in float64, not in {self.dtype}")

    def load(self, values: Array, memory: Memory) -> Array:
        """See `Backend.load`."""
        return np.array(values, dtype=np.float64) if memory == "lam" else np.asarray(values) > 0

    def read(self, plane: Array) -> Array:
        """See `Backend.read`."""
        return plane.copy()

    def convert(self, plane: Array, memory: Memory) -> Array:
        """See `Backend.convert`."""
        return plane > 0 if memory == "llm" else np.where(plane, 1.0, -1.0)

    def output(self, x: Array) -> Array:
        """See `Backend.output`."""
        return output(x)

    def transient(
        self, plan: Plan, x: Array, u: Array | None, bias: Array | None = None, mask: Array | None = None
    ) -> Outcome:
        """See `Backend.transient`."""
        if plan.method == "general":
            return reference_general.transient(plan, x, u, bias, mask)
        bias = reference_general.with_control_terms(plan.template, plan.boundary, u, bias)
        w = np.full_like(x, plan.template.z)
        if bias is not None:
            w += bias
        if u is not None:
            w = correlate(u, plan.template.control_taps, plan.boundary, plan.boundary.u, w)
        free = np.ones(x.shape, dtype=bool) if mask is None else ~mask
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is found and reported below
            outcome = _ROADS[plan.method](plan, x, w, free)
        check_finite(outcome.x, outcome.t)
        return outcome

    def cellwise(self, operation: Cellwise, planes: Sequence[Array], parameters: Sequence[float]) -> tuple[Array, ...]:
        """See `Backend.cellwise`."""
        return operation.array(*planes, *parameters)

    def logic(self, function: int, p: Array, q: Array) -> Array:
        """See `Backend.logic`."""
        return truth_table(function)[2 * p.astype(int) + q.astype(int)]

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Array) -> Array:
        """See `Backend.neighbourhood`."""
        r, (rows, cols) = rule.radius, plane.shape[-2:]
        around = pad(plane, r, boundary, boundary.u > 0)
        seen = [around[..., r + k : r + k + rows, r + l : r + l + cols] != negated for k, l, negated in rule.literals]
        combine = np.logical_and if rule.conjunction else np.logical_or
        return combine.reduce(seen) if seen else np.full(plane.shape, rule.conjunction)

    def count(self, plane: Array) -> int | NDArray[np.int64]:
        """See `Backend.count`."""
        black = np.count_nonzero(plane, axis=(-2, -1))
        return black if plane.ndim == 3 else int(black)


def _drive(plan: Plan, x: Array, w: Array) -> Array:
    """A*y + w."""
    return correlate(output(x), plan.feedback_taps, plan.boundary, plan.boundary.y, w)


def _closed_form(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    settled = plan.duration == "settled"
    t = math.inf if settled else float(plan.duration)
    end = uncoupled_state(x, w, plan.template.self_feedback, t, plan.cell)
    return Outcome(np.where(free, end, x), t, settled, 0.0 if settled else math.nan)


def _stepped(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    for step in range(plan.steps):
        if plan.duration == "settled" and step % plan.check_every == 0:
            settled, largest = _look(plan, x, w, free)
            if settled:
                return Outcome(x, step * plan.step, True, largest)
        x = np.where(free, _step(plan, x, w), x)
    if plan.duration != "settled":
        return Outcome(x, float(plan.duration), False, math.nan)
    settled, largest = _look(plan, x, w, free)
    return Outcome(x, plan.steps * plan.step, settled, largest)


def _step(plan: Plan, x: Array, w: Array) -> Array:
    """One step of the scheme's table; in the full-range model every stage ends inside the walls."""
    assert plan.scheme is not None
    h = plan.scheme.gain(plan.step)
    wall = output if plan.cell == "full-range" else np.positive
    slopes: list[Array] = []
    for row in plan.scheme.a:
        stage = x
        for weight, k in zip(row, slopes, strict=False):
            stage = stage + h * weight * k
        stage = wall(stage)
        slopes.append(_drive(plan, stage, w) - stage)
    for weight, k in zip(plan.scheme.b, slopes, strict=True):
        x = x + h * weight * k
    return wall(x)


def _look(plan: Plan, x: Array, w: Array, free: Array) -> tuple[bool, float]:
    """Return whether the network has settled (see `Plan`) and the largest |dx/dt|."""
    drive = _drive(plan, x, w)
    largest = float(np.abs(rate(drive, x, plan.cell)[free]).max(initial=0.0))
    stuck = (np.abs(x) >= 1) & (np.sign(x) * drive >= 1)
    final = plan.cell == "chua-yang" and plan.step <= 1 and bool(stuck[free].all())
    return final or largest <= SETTLED_RATE, largest


def _adaptive(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    from scipy.integrate import solve_ivp

    assert plan.duration != "settled"

    def derivative(_t: float, flat: Array) -> Array:
        now = flat.reshape(x.shape)
        now = output(now) if plan.cell == "full-range" else now
        return np.where(free, rate(_drive(plan, now, w), now, plan.cell), 0.0).ravel()

    solution = solve_ivp(derivative, (0.0, plan.duration), x.ravel(), method="DOP853", rtol=1e-10, atol=1e-12)
    if not solution.success:
        raise InputError(f"the adaptive scheme gave up at t = {solution.t[-1]:g}: {solution.message}")
    end = solution.y[:, -1].reshape(x.shape)
    return Outcome(output(end) if plan.cell == "full-range" else end, float(plan.duration), False, math.nan)


_ROADS = {"closed form": _closed_form, "stepped": _stepped, "adaptive": _adaptive}
