"""A transient to an accuracy: the cheapest way that is known to reach it, and how near the run says it came."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cnnsim.accuracy.at_rest import seen_to_the_end
from cnnsim.accuracy.exact_flow import exact_state
from cnnsim.accuracy.ladder import Ladder
from cnnsim.accuracy.settle import Ending
from cnnsim.accuracy.steps import by_steps, longest_step
from cnnsim.accuracy.system import linear_system
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends import in_float64
from cnnsim.backends.base import Backend, Outcome
from cnnsim.backends.reference.drive import control
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import EULER, RK4
from cnnsim.support import Array, Flags, InputError

MOST_KINK_CELLS = 400
"""Cells of a grid up to which going from kink to kink costs less than steps that are short enough."""
_KINKS_PAY_BELOW = 3e-7

Start = Callable[[Backend, Plan], Outcome]


@dataclass(frozen=True)
class Reached:
    """The end of a transient to an accuracy: the state, its error by the run's own estimate, the cells not vouched for.

    ``plan`` is that of the run that counts; ``how`` says in words what was done and why.
    """

    x: Array
    t: float
    settled: bool
    rate: float
    error: float
    undecided: Flags
    plan: Plan
    how: str


@dataclass(frozen=True)
class Transient:
    """A transient that can be run again: its ``plan``, ``start`` on a backend by another plan, and its planes.

    ``planes`` are state, input, bias and mask as arrays (or None, or sequences).
    """

    plan: Plan
    start: Start
    planes: tuple[Any, Any, Any, Any]

    def reach(self, backend: Backend, wanted: Wanted) -> Reached:
        """Run it to an accuracy on a backend, in float64 where float32 cannot give it.

        Raises:
            InputError: a device without float64 where that is needed.
        """
        where, told = backend, ""
        if wanted.dtype == "float64" and backend.dtype != "float64":
            where, told = in_float64(backend), f"; in float64, as float32 cannot give {wanted}"
            if where.dtype != "float64":
                raise InputError(f"accuracy {wanted}: the device has no float64, and float32 cannot give it")
        if self.plan.cell == "discrete-time":
            found = self._once(where, "discrete time has no error")
        elif self.plan.method == "closed form":
            found = self._closed(where)
        elif self.plan.duration == "settled":
            found = self._settled(where, wanted)
        elif self._kinks_pay(wanted):
            found = self._by_kinks()
        else:
            found = self._by_steps(where, wanted)
        return replace(found, how=f"accuracy {wanted}: {found.how}{told}")

    def _once(self, where: Backend, how: str) -> Reached:
        outcome = self.start(where, self.plan)
        x = where.read(outcome.x)
        return Reached(
            x, outcome.t, outcome.settled, outcome.rate, 0.0, np.zeros(x.shape, bool), self.plan, how
        )  # fmt: skip

    def _closed(self, where: Backend) -> Reached:
        """One run: what rounding has added grows with the state, and with exp((a - 1) t) while a cell is linear."""
        found = self._once(where, "each cell has an exact solution")
        a, t = self.plan.template.self_feedback, min(found.t, 40.0)
        size = max(1.0, float(np.abs(found.x).max()))
        start = np.abs(self._drive() + (a - 1) * np.clip(self.planes[0], -1, 1)) if a > 1 else np.ones(found.x.shape)
        eps = float(np.finfo(where.dtype).eps)
        y = self.plan.output(found.x)
        unsure = (start <= 4 * eps * size) | ((np.abs(y) < 1) & (a > 1) & found.settled)
        grown = np.exp(max(0.0, a - 1) * t) if not found.settled else 1.0
        inside = float(np.abs(y).min()) < 1 and not found.settled
        return replace(found, error=4 * eps * size * (grown if inside else 1.0), undecided=unsure)

    def _settled(self, where: Backend, wanted: Wanted) -> Reached:
        """Run until it settles with two different steps: where they end must be the same."""
        u, bias, mask = _loaded(where, *self.planes[1:])
        ends: list[tuple[Outcome, Ending, Plan, Array]] = []
        for part in (1.0, 0.5, 0.125):
            plan = self.plan if part == 1.0 else by_steps(self.plan, self.plan.scheme or EULER, self.plan.step * part)
            outcome = self.start(where, plan)
            if not outcome.settled:
                x = where.read(outcome.x)
                return Reached(x, outcome.t, False, outcome.rate, math.inf, np.ones(x.shape, bool), plan, "not settled")
            outcome, ending = seen_to_the_end(where, plan, outcome, u, bias, mask, wanted.error / 2)
            x = where.read(outcome.x) if ending.x is None else ending.x
            ends.append((outcome, ending, plan, x))
            if len(ends) > 1:
                y, before = (plan.output(end[3]) for end in ends[-2:])
                apart = np.abs(y - before)
                if float(apart.max()) <= wanted.error or (wanted.signs and np.array_equal(y > 0, before > 0)):
                    break
        y, before = (plan.output(end[3]) for end in ends[-2:])
        apart = np.abs(y - before)
        unsure = (np.sign(y) != np.sign(before)) & (apart > wanted.error)
        if ending.undecided.size == unsure.size:
            unsure |= ending.undecided
        same = apart[~unsure].max(initial=0.0)
        how = f"steps of {plan.step:g} and {ends[-2][2].step:g} lead to one end; {ending.how}"
        if unsure.any():
            how = f"{int(unsure.sum())} cells end elsewhere with shorter steps, or on a ridge; {ending.how}"
        error = max(ending.distance, float(same) / 2, float(np.finfo(where.dtype).eps))
        return Reached(x, outcome.t, outcome.settled, outcome.rate, error, unsure, plan, how)

    def _kinks_pay(self, wanted: Wanted) -> bool:
        plan = self.plan
        return kinks_pay(plan, wanted) and self.planes[0].ndim == 2

    def _drive(self) -> Array:
        return control(self.plan, *self.planes[:3])

    def _by_kinks(self) -> Reached:
        plan, (state, _, _, mask) = self.plan, self.planes
        system = linear_system(
            plan.template.feedback_taps, plan.shape, plan.boundary, limited=plan.cell == "full-range"
        )
        free = np.ones(state.size, bool) if mask is None else ~mask.ravel()
        system = system.with_planes(self._drive().ravel(), free)
        duration = float(plan.duration)
        x = exact_state(system, state.ravel(), duration)
        again = exact_state(replace(system, drive=system.drive + 0.0), state.ravel() * (1 + 4e-15), duration)
        error = max(2e-14, float(np.abs(x - again).max()))  # how much rounding errors grow
        x = x.reshape(state.shape)
        how = "from kink to kink by the matrix exponential; its error is how far rounding moves it"
        return Reached(x, duration, False, math.nan, error, np.abs(x) <= error, plan, how)

    def _by_steps(self, where: Backend, wanted: Wanted) -> Reached:
        plan = self.plan
        divides = plan.method == "general" and self._timed()
        scheme = EULER if divides and delays_of(plan.network) else RK4  # type: ignore[arg-type]  # general plans have one
        longest = plan.step if divides else longest_step(plan, scheme)
        if not plan.duration:
            return self._once(where, "no time goes by")
        plans: list[Plan] = []

        def run(step: float) -> Array:
            plans.append(by_steps(plan, scheme, step, timed=divides))
            return where.read(self.start(where, plans[-1]).x).astype(np.float64)

        size = max(1.0, float(np.abs(self.planes[0]).max()))
        floor = float(np.finfo(where.dtype).eps) * size * 4
        ladder = Ladder(run, plan.output, min(longest, float(plan.duration)), divides, floor)
        error, unsure, reached = ladder.climb(wanted)
        taken = ", ".join(f"{step:.3g}" for step in ladder.steps)
        how = f"{scheme.name} by steps of {taken}; the last two runs differ by {ladder.differences[-1]:.2g}"
        how += "" if reached else f"; {wanted} was not reached"
        x = ladder.ends[-1].astype(where.dtype)
        return Reached(x, float(plan.duration), False, math.nan, error, unsure, plans[-1], how)

    def _timed(self) -> bool:
        from cnnsim.network import Frames  # no cost, but only general plans ask

        assert self.plan.network is not None
        return bool(delays_of(self.plan.network)) or any(isinstance(plane, Frames) for plane in self.planes)


def kinks_pay(plan: Plan, wanted: Wanted) -> bool:
    """Return whether going from kink to kink costs less than steps as short as the accuracy needs."""
    few = math.prod(plan.shape) <= MOST_KINK_CELLS
    return plan.method == "stepped" and not wanted.signs and wanted.error <= _KINKS_PAY_BELOW and few


def decided(plan: Plan, wanted: Wanted) -> tuple[str, str]:
    """Return what an accuracy decides about a plan, and why, for people."""
    if plan.cell == "discrete-time" or plan.method == "closed form":
        why = "the plan's own, which is exact"
    elif plan.duration == "settled":
        why = f"two runs, the step of one half that of the other, must end alike, within {wanted} of the rest"
    elif kinks_pay(plan, wanted):
        why = f"from kink to kink: on {math.prod(plan.shape)} cells that costs less than steps short enough"
    else:
        why = "rk4 instead, by shorter and shorter steps until two runs agree; its kinks cost order 4 down to 2"
    return f"accuracy {wanted}", f"{why}; {wanted.dtype} or more"


def _loaded(where: Backend, u: Any, bias: Any, mask: Any) -> tuple[Any, Any, Any]:
    planes = [None if plane is None else where.load(plane, "lam") for plane in (u, bias)]
    return planes[0], planes[1], None if mask is None else where.load(mask, "llm")
