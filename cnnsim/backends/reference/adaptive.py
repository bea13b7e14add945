"""Adaptive steps by scipy (DOP853) for reference solutions; only this backend has them."""

import math
from typing import Any

import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.backends.reference.transient import ReferenceLinearSteps
from cnnsim.network.cell import output, rate
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError


def linear(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    """Run a linear template; full-range states are clipped to +-1 wherever they are read."""
    steps, limited = ReferenceLinearSteps(plan, x, w, free), plan.cell == "full-range"

    def derivative(_t: float, flat: Array) -> Array:
        now = flat.reshape(x.shape)
        now = output(now) if limited else now
        return np.where(free, rate(steps.drive(now), now, plan.cell), 0.0).ravel()

    end = _integrate(plan, derivative, x)
    return Outcome(output(end) if limited else end, float(plan.duration), False, math.nan)


def general(network: ReferenceNetwork) -> Outcome:
    """Run a network of terms.

    Raises:
        InputError: full-range cells.
    """
    plan = network.plan
    if plan.cell == "full-range":
        raise InputError("the adaptive scheme has no limiter; full-range cells with terms take a fixed step")

    def derivative(_t: float, flat: Array) -> Array:
        x = flat.reshape(network.x.shape)
        return np.where(network.free, (network.drive(x, 0) - x) * network.rates, 0.0).ravel()

    return Outcome(_integrate(plan, derivative, network.x), float(plan.duration), False, math.nan)


def _integrate(plan: Plan, derivative: Any, x: Array) -> Array:
    from scipy.integrate import solve_ivp  # slow to import and seldom used

    assert plan.duration != "settled"
    solution = solve_ivp(derivative, (0.0, plan.duration), x.ravel(), method="DOP853", rtol=1e-10, atol=1e-12)
    if not solution.success:
        raise InputError(f"the adaptive scheme gave up at t = {solution.t[-1]:g}: {solution.message}")
    return np.reshape(solution.y[:, -1], x.shape)
