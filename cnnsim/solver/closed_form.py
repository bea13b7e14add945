"""Uncoupled cells by their closed form: which of them rounding, or the last digit of an input, decides."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.network import Term, pad
from cnnsim.planning.plan import Plan
from cnnsim.solver.problem import Solution, TransientProblem, largest
from cnnsim.support import Array, Floats


def by_closed_form(problem: TransientProblem, where: Backend, jumps: Floats | None) -> Solution:
    """Return the exact end of uncoupled cells; ``jumps`` of their drives with the last digit of an input.

    Rounding errors grow with the state, and with exp((a - 1) t) while a cell is linear. At its rest a cell with a > 1
    has the sign of w + (a - 1) y(0), others that of w, so a jump decides where it is larger.
    """
    found = problem.once(where, "each cell has an exact solution")
    plan, (state, u, bias, _) = problem.plan, problem.planes
    a, eps = plan.template.self_feedback, float(np.finfo(where.dtype).eps)
    size = max(1.0, largest(found.x))
    y: Array = plan.output(found.x)
    start: Array = np.ones(state.shape)  # with a <= 1 a run of a given time forgets its start
    if a > 1 or plan.duration == "settled":
        at_rest = plan.duration == "settled" and plan.cell == "chua-yang"
        start = found.x - a * y if at_rest else control(plan, state, u, bias)
        if a > 1:
            start += (a - 1) * np.clip(state, -1, 1)
        np.abs(start, out=start)
    undecided = start <= 4 * eps * size
    if a <= 1:
        undecided &= start > 0  # a sum that is 0 without rounding is 0
    elif plan.duration == "settled":
        undecided |= np.abs(y) < 1
    if jumps is not None:
        undecided |= (jumps > 0) & (start <= jumps) if plan.duration == "settled" else jumps > 0
    error = 4 * eps * size
    if plan.duration != "settled" and a > 1 and float(np.abs(y).min()) < 1:
        error *= math.exp((a - 1) * min(found.t, 40.0))
    return replace(found, error=error, undecided=problem.free(undecided))


def edge_jumps(plan: Plan, shape: tuple[int, ...], u: Any, dtype: Any) -> Floats | None:
    """Return how much the drive of each cell changes at most if inputs at the edge of a table's step cross it.

    An input is at an edge if the distance is below the rounding of ``dtype``; one that lies on it exactly is decided by
    the table. ``shape`` is the state's. None: no input is at an edge.
    """
    layers = (plan.template,) if plan.network is None else plan.network.layers
    terms = [(n, term) for n, layer in enumerate(layers) for term in layer.control_terms if _edges(term)]
    if not terms or not isinstance(u, np.ndarray):
        return None
    found = np.zeros(shape)
    by_layer = found.reshape(-1, len(layers), *shape[-2:])
    inputs = np.broadcast_to(u, shape).reshape(by_layer.shape).astype(np.float64, copy=False)
    size = max(1.0, largest(u))
    near = 2 * float(np.finfo(dtype).eps) * size
    least = 5e-324 if bool((inputs == inputs.astype(dtype)).all()) else 0.0  # exact distances are known
    for n, term in terms:
        rows, cols = plan.shape
        around = pad(inputs[:, n], term.radius, plan.boundary, plan.boundary.u)
        for k, l, weight in term.taps:
            top, left = term.radius + k, term.radius + l
            values = around[:, top : top + rows, left : left + cols]
            values = values if term.of.centre is None else values - inputs[:, n]
            jump = float(np.abs(weight).max()) * (1.0 if term.times is None else 2.0 * size)
            for edge, height in _edges(term):
                away = np.abs(values - edge)
                by_layer[:, n] += jump * height * ((away <= near) & (away >= least))
    return found if found.any() else None


def _edges(term: Term) -> list[tuple[float, float]]:
    """Return the places at which the table of a term jumps, with the heights."""
    table = term.table
    if table is None or table.kind != "step":
        return []
    steps = zip(table.at, table.values, table.values[1:], strict=False)
    return [(at, abs(high - low)) for at, low, high in steps if low != high]
