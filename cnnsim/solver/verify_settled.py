"""Verification of settled networks: their outputs within a distance of their rest, or the rest itself."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.backends import in_float64
from cnnsim.backends.base import Backend, Outcome
from cnnsim.backends.reference.drive import control
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.solver.rest_distance import Ending, SettledState, contraction_bound, solving_bytes
from cnnsim.support import Array
from cnnsim.support.memory import LARGE, check_memory

_NO_CELL = np.zeros((0, 0), bool)
_NEUTRAL = 1e-5
"""Difference from 1 of the sum of A that rounding may hide in float32."""


def verify_settled(
    backend: Backend, plan: Plan, outcome: Outcome, u: Any, bias: Any, mask: Any, distance: float
) -> tuple[Outcome, Ending]:
    """Return the settled outcome with its outputs within ``distance`` of the rest, or as one that has not settled.

    Arguments: planes of the backend, as `Backend.transient` takes them. The ``x`` of the ending is None where the state
    stays as it is.
    """
    ends = not outcome.rate if plan.cell == "discrete-time" else outcome.saturated and not is_neutral(plan)
    if ends or outcome.rate > 1.001 * SETTLED_RATE:  # float32 may miss the rate by that
        return outcome, Ending(None, outcome.t, 0.0, _NO_CELL, "no output can change")
    if plan.method == "closed form":
        undecided = _NO_CELL
        if plan.template.self_feedback > 1:
            undecided = np.abs(backend.read(outcome.x, copy=False)) < 1
            undecided = undecided if mask is None else undecided & ~backend.read(mask)
        return outcome, Ending(None, outcome.t, 0.0, undecided, "each cell has an exact solution")
    rounding = 4.0 * float(np.finfo(backend.dtype).eps)
    if (bound := contraction_bound(plan, outcome.rate + rounding)) <= distance:
        return outcome, Ending(None, outcome.t, bound, _NO_CELL, "A is a contraction: |dx/dt| / (1 - sum|A|)")
    x, masked = backend.read(outcome.x, copy=False), None if mask is None else backend.read(mask)
    if plan.method == "stepped" and x.size >= LARGE:
        what = f"the rest of template {plan.template.name!r}, whose outputs are grey, on {x.size} cells"
        check_memory(what, solving_bytes(plan) * x.size, "a duration instead of 'settled', or a smaller grid, wanted")
    planes = [None if plane is None else backend.read(plane).astype(np.float64) for plane in (u, bias)]
    drive = control(plan, x.astype(np.float64), *planes) if plan.method == "stepped" else None
    fine: list[Any] = []  # in float64: in float32 slow modes stop far from their rest

    def run(state: Array, duration: float) -> Array:
        if not fine:
            where = in_float64(backend)
            loaded = [None if plane is None else where.load(plane, "lam") for plane in planes]
            fine.extend((where, *loaded, None if masked is None else where.load(masked, "llm")))
        where, *loaded = fine
        onward = replace(plan, duration=duration, savings=plan.savings - {"sleep"})
        return where.read(where.transient(onward, where.load(state, "lam"), *loaded).x)

    ending = SettledState(plan, drive, (planes[0], planes[1]), masked, run).ending(x, outcome.t, distance)
    if ending.x is x:
        return outcome, ending._replace(x=None)
    ending = ending._replace(x=ending.x.astype(backend.dtype))
    settled = ending.distance <= distance
    rate = 0.0 if ending.t == math.inf else outcome.rate if settled else math.nan
    return Outcome(backend.load(ending.x, "lam"), ending.t, settled, rate), ending


def is_neutral(plan: Plan) -> bool:
    """Return whether equal outputs drive each other by 1, so that rounding decides whether they stay saturated."""
    return plan.method == "stepped" and abs(float(plan.template.A.sum()) - 1.0) < _NEUTRAL
