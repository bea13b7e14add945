"""The time loop of the backends: spans of constant input, checks whether the network has settled, slices of time.

Euler steps of a linear template on the CPU have this loop compiled: see `cnnsim.backends.cpu.tiles.dense`.
"""

import math
from collections.abc import Iterable

from cnnsim.backends.base import Check, CheckedStepper, Outcome, SettlingStepper
from cnnsim.backends.slices import Pace
from cnnsim.planning.plan import Plan


def run(plan: Plan, stepper: CheckedStepper, spans: Iterable[tuple[int, int]] | None = None) -> Outcome:
    """Run a transient to its end.

    For ``"settled"`` the state is checked before the first step, once a time constant, and at the limit. Discrete time
    is checked before each step, and ends at once in a cycle of two states.

    Arguments: ``spans`` are (first step, steps) in which input and bias are constant, None for one span.
    """
    settling, every = plan.duration == "settled", plan.check_every
    pace, rate = Pace(plan, stepper.work, stepper.together, stepper.few), math.nan
    for first, count in [(0, plan.steps)] if spans is None else list(spans) or [(0, 0)]:
        stepper.start_span(first)
        step, end = first, first + count
        while step < end:
            if settling and step % every == 0:
                check = stepper.check_settled(step, last=False)
                if check.settled or check.repeats:
                    pace.over()
                    t = step * plan.step
                    return Outcome(stepper.finish(), t, check.settled, check.rate, check.saturated)
                rate = check.rate
            until = min(end, (step // every + 1) * every) if settling else end
            now = min(until - step, pace.left)
            stepper.advance(step, now)
            step += now
            pace.left -= now
            if pace.left <= 0:
                stepper.wait()
                pace.turn(step, rate)
    pace.over()
    if not settling:
        return Outcome(stepper.finish(), float(plan.duration), False, math.nan)
    check = stepper.check_settled(plan.steps, last=True)
    return Outcome(stepper.finish(), plan.steps * plan.step, check.settled, check.rate, check.saturated)


def run_with_checks(plan: Plan, stepper: SettlingStepper) -> Outcome:
    """Run a transient to its end with a stepper that takes steps and their checks in one call."""
    settling, check = plan.duration == "settled", Check(math.nan)
    step, pace = 0, Pace(plan, stepper.work, stepper.together, stepper.few)
    while True:
        count = min(plan.steps - step, pace.left)
        if settling:
            count = min(count, stepper.checks * plan.check_every)
            taken, check = stepper.settle(step, count, last=step + count == plan.steps)
            step += taken
        else:
            stepper.advance(step, count)
            step += count
            if step < plan.steps:
                stepper.wait()
        if check.settled or step == plan.steps:
            pace.over()
            t = step * plan.step if settling else float(plan.duration)
            return Outcome(stepper.finish(), t, check.settled, check.rate, check.saturated)
        pace.turn(step, check.rate)
