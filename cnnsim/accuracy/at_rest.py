"""Planes of a backend that have settled: seen to their end, as `settle` promises, before they are called so."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.accuracy.settle import Ending, Settling, contraction_bound, solving_bytes
from cnnsim.backends import in_float64
from cnnsim.backends.base import Backend, Outcome
from cnnsim.backends.reference.drive import control
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array
from cnnsim.support.memory import LARGE, check_memory

_NOWHERE = np.zeros((0, 0), bool)
_PART = 1 << 16


def seen_to_the_end(
    backend: Backend, plan: Plan, outcome: Outcome, u: Any, bias: Any, mask: Any, promise: float
) -> tuple[Outcome, Ending]:
    """Return the settled outcome with its outputs within ``promise`` of their end, or as one that has not settled.

    Arguments: planes of the backend, as `Backend.transient` takes them. The ``x`` of the ending is None where the state
    stays as it is.
    """
    if (
        outcome.saturated or plan.cell == "discrete-time" or outcome.rate > 1.001 * SETTLED_RATE
    ):  # by which float32 may miss it
        return outcome, Ending(None, outcome.t, 0.0, _NOWHERE, "no output can change")
    if plan.method == "closed form":
        ridge = _NOWHERE
        if plan.template.self_feedback > 1:
            ridge = np.abs(backend.read(outcome.x, copy=False)) < 1
            ridge = ridge if mask is None else ridge & ~backend.read(mask)
        return outcome, Ending(None, outcome.t, 0.0, ridge, "each cell has an exact solution")
    if (bound := contraction_bound(plan, outcome.rate)) <= promise:
        return outcome, Ending(None, outcome.t, bound, _NOWHERE, "A is a contraction: |dx/dt| / (1 - sum|A|)")
    x, black = backend.read(outcome.x, copy=False), None if mask is None else backend.read(mask)
    if plan.method == "stepped" and plan.cell == "chua-yang" and _saturated(x, black):
        return outcome, Ending(None, outcome.t, 0.0, _NOWHERE, "no output can change")
    if plan.method == "stepped" and x.size >= LARGE:
        what = f"the rest of template {plan.template.name!r}, whose outputs are grey, on {x.size} cells"
        check_memory(what, solving_bytes(plan) * x.size, "a duration instead of 'settled', or a smaller grid, wanted")
    given = [None if plane is None else backend.read(plane).astype(np.float64) for plane in (u, bias)]
    drive = control(plan, x.astype(np.float64), *given) if plan.method == "stepped" else None
    exact: list[Any] = []  # float32 stands still far from the end of slow modes

    def run(state: Array, duration: float) -> Array:
        if not exact:
            where = in_float64(backend)
            planes = [None if plane is None else where.load(plane, "lam") for plane in given]
            exact.extend((where, *planes, None if black is None else where.load(black, "llm")))
        where, *planes = exact
        onward = replace(plan, duration=duration, savings=plan.savings - {"sleep"})
        return where.read(where.transient(onward, where.load(state, "lam"), *planes).x)

    ending = Settling(plan, drive, black, run).end(x, outcome.t, outcome.rate, promise)
    if ending.x is x:
        return outcome, ending._replace(x=None)
    ending = ending._replace(x=ending.x.astype(backend.dtype))
    settled = ending.distance <= promise
    rate = 0.0 if ending.t == math.inf else outcome.rate
    return Outcome(backend.load(ending.x, "lam"), ending.t, settled, rate), ending


def _saturated(x: Array, held: Any) -> bool:
    """Whether every cell that may move is saturated, seen in parts: a plane would be a fifth of a run's memory."""
    cells, kept = x.reshape(-1), None if held is None else held.reshape(-1)
    for at in range(0, cells.size, _PART):
        outside = np.abs(cells[at : at + _PART]) >= 1
        if not (outside if kept is None else outside | kept[at : at + _PART]).all():
            return False
    return True
