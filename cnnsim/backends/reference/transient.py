"""Linear templates: steps of dx/dt = -x + A*y + w by a Runge-Kutta scheme, checks, and the closed form."""

import math

import numpy as np

from cnnsim.backends.base import Check, CheckedStepper, Outcome
from cnnsim.network.boundary import correlate
from cnnsim.network.cell import output, rate, uncoupled_state
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


class ReferenceLinearSteps(CheckedStepper):
    """Steps of a linear template; in the full-range model every stage ends within +-1."""

    def __init__(self, plan: Plan, x: Array, w: Array, free: Array) -> None:
        self._plan, self._x, self._w, self._free = plan, x, w, free
        self.work = x.size * len(plan.feedback_taps)
        self._limit = output if plan.cell == "full-range" else np.positive

    def drive(self, x: Array) -> Array:
        """Return A*y + w."""
        return correlate(output(x), self._plan.feedback_taps, self._plan.boundary, self._plan.boundary.y, self._w)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        return check(self._plan, self._x, self.drive(self._x), self._free)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        for _ in range(count):
            self._x = np.where(self._free, self._after(self._x), self._x)

    def _after(self, x: Array) -> Array:
        scheme = self._plan.scheme
        assert scheme is not None
        h = scheme.gain(self._plan.step)
        rates: list[Array] = []
        for row in scheme.a:
            stage = x
            for weight, k in zip(row, rates, strict=False):
                stage = stage + h * weight * k
            stage = self._limit(stage)
            rates.append(np.where(self._free, self.drive(stage) - stage, 0.0))  # held in the stages, too
        for weight, k in zip(scheme.b, rates, strict=True):
            x = x + h * weight * k
        return self._limit(x)

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._x


def check(plan: Plan, x: Array, drive: Array, free: Array) -> Check:
    """Check a state whose drive is A*y + w; ``free`` marks the cells that no mask holds."""
    largest = float(np.abs(rate(drive, x, plan.cell)[free]).max(initial=0.0))
    saturated = (np.abs(x) >= 1) & (np.sign(x) * drive >= 1)
    return Check(largest, plan.saturation_ends and bool(saturated[free].all()))


def closed_form(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    """Return the state of uncoupled cells after the plan's duration, or their steady state."""
    settled = plan.duration == "settled"
    t = math.inf if settled else float(plan.duration)
    end = uncoupled_state(x, w, plan.template.self_feedback, t, plan.cell)
    return Outcome(np.where(free, end, x), t, settled, 0.0 if settled else math.nan)
