"""The plan of a transient again, by another scheme and step, and the longest step to begin with."""

import math
from dataclasses import replace

from cnnsim.planning.network_modes import step_bound
from cnnsim.planning.plan import Plan
from cnnsim.planning.savings import stepped_savings
from cnnsim.planning.scheme import Scheme
from cnnsim.planning.stability import step_limit
from cnnsim.planning.step import check_count, divided


def by_steps(plan: Plan, scheme: Scheme, step: float, *, timed: bool = False) -> Plan:
    """Return the plan with a scheme and a step, made to fit the duration; ``timed``: it divides all times as it is."""
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


def evaluations(plan: Plan) -> int:
    """Return how often a plan evaluates A*y in each cell."""
    return plan.steps * (len(plan.scheme.b) if plan.scheme else 1)
