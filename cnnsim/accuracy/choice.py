"""Scheme and step for a large grid: the cheapest that reaches an accuracy on a sample of its windows."""

from collections.abc import Callable
from dataclasses import dataclass

from cnnsim.accuracy.ladder import Ladder
from cnnsim.accuracy.repeatable import largest
from cnnsim.accuracy.steps import evaluations, longest_step
from cnnsim.accuracy.wanted import Wanted
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import EULER, HEUN, RK4, Scheme
from cnnsim.support import Array

TAIL = 1.5
"""How much larger the largest error of a grid is taken to be than that of a sample of it."""
_FINER = 0.1
"""Of the accuracy that the sample's own truth is known to."""
_COSTS = {"euler": 0.5, "heun": 1.0, "rk4": 1.0}
"""Time of an evaluation of A*y in a scheme: Euler's need no planes in between."""


@dataclass(frozen=True)
class Choice:
    """A plan for the whole grid, and the error that it had on the sample."""

    plan: Plan
    error: float

    @property
    def cost(self) -> float:
        """Evaluations of A*y, each weighed by its time."""
        return evaluations(self.plan) * _COSTS.get(self.plan.scheme.name if self.plan.scheme else "", 1.0)


def choose(
    ladder: Ladder, run: Callable[[Plan], Array], planned: Callable[[Scheme, float], Plan], wanted: float
) -> tuple[Choice, float]:
    """Return the cheapest plan that reaches an error on the sample, and rk4's step that does.

    ``ladder`` of the sample by rk4 gives its truth; ``run`` gives the sample's end by a plan, ``planned`` makes one of
    a scheme and a step. An error on the sample counts `TAIL` times.
    """
    goal = wanted / TAIL
    ladder.climb(Wanted(max(_FINER * goal, 4 * ladder.floor)))
    truth, own = ladder.ends[-1], ladder.bound()

    def tried(scheme: Scheme, step: float) -> Choice:
        plan = planned(scheme, step)
        return Choice(plan, largest(run(plan) - truth) + own)

    found = _reaching(tried, RK4, _step_of(ladder, goal), goal)
    rk4_step = found.plan.step
    for scheme, stages in ((EULER, 8.0), (HEUN, 2.0)):  # at the step from which on it would cost less
        step = min(found.plan.step / stages, longest_step(found.plan, scheme)) * 1.01
        first = tried(scheme, step)
        if first.error <= goal and first.cost < found.cost:
            found = _longer(tried, first, goal, longest_step(found.plan, scheme))
    return found, rk4_step


def _step_of(ladder: Ladder, goal: float) -> float:
    """Return the rk4 step whose error the ladder's differences promise to be the goal."""
    step = ladder.steps[0]
    for shorter, difference in zip(ladder.steps[1:], ladder.differences, strict=True):
        if difference <= goal:
            return step
        step = max(shorter, step * (0.8 * goal / difference) ** 0.5)
        if step > shorter:
            return step
    return step


def _reaching(tried: Callable[[Scheme, float], Choice], scheme: Scheme, step: float, goal: float) -> Choice:
    """Return the first choice that reaches the goal, or the last of a few by shorter and shorter steps."""
    found = tried(scheme, step)
    for _ in range(3):
        if found.error <= goal:
            break
        found = tried(scheme, found.plan.step * max(1 / 4, 0.8 * (goal / found.error) ** 0.5))
    return found


def _longer(tried: Callable[[Scheme, float], Choice], found: Choice, goal: float, longest: float) -> Choice:
    """Return a choice by a longer step, as long as the goal allows for it by the scheme's order."""
    assert found.plan.scheme is not None
    part = (0.8 * goal / max(found.error, 1e-300)) ** (1 / found.plan.scheme.order)
    if part < 1.2:
        return found
    again = tried(found.plan.scheme, min(found.plan.step * part, longest))
    return again if again.error <= goal else found
