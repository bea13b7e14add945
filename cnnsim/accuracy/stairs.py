"""Cells whose drive jumps where their own state passes inputs: their exact flow, from jump to jump.

Rank templates compare a cell's state with each input around it, by a table that is a step. The rate of such a cell
is a function of its own state alone, so it goes one way, and stops at the first place that drives it back (Filippov,
"Differential Equations with Discontinuous Righthand Sides", 1988, section 4): steps of any length chatter there.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.accuracy.repeatable import Reached, Repeatable, largest
from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.network import Term, pad
from cnnsim.network.characteristic import CLIP
from cnnsim.planning.plan import Plan

_ROUNDING = 4e-15
"""Of sums of some ten numbers of about 1, in float64."""


def has_stairs(plan: Plan) -> bool:
    """Return whether no cell feels another's state, and what it feels of its own jumps, but has no slope."""
    network = plan.network
    if plan.method != "general" or network is None or len(network.layers) > 1 or plan.characteristic is not CLIP:
        return False
    layer = network.layers[0]
    alone = not any((k, l) != (0, 0) and weight for k, l, weight in layer.feedback_taps)
    return plan.cell == "chua-yang" and alone and bool(layer.feedback_terms) and all(map(_jumps, layer.feedback_terms))


def _jumps(term: Term) -> bool:
    compared = str(term.of) == "u_kl - x_ij" and term.times is None and not term.delay and term.layer in (None, 0)
    return compared and term.table is not None and term.table.kind == "step" and term.weights.ndim == 2


def by_stairs(transient: Repeatable, where: Backend) -> Reached | None:
    """Return the exact end of cells with stairs; None if input or bias change with time."""
    from cnnsim.accuracy.uncoupled.stairs_loops import flow_of_cells  # numba is slow to import

    plan, (state, u, bias, mask) = transient.plan, transient.planes
    if not isinstance(u, np.ndarray) or not isinstance(bias, np.ndarray | None):
        return None
    assert plan.network is not None
    layer, grids = plan.network.layers[0], (-1, *plan.shape)
    x = np.array(np.broadcast_to(state, state.shape), np.float64).reshape(grids)
    inputs = np.broadcast_to(u, state.shape).astype(np.float64).reshape(grids)
    given = None if bias is None else np.broadcast_to(bias, state.shape).astype(np.float64).reshape(grids)
    drive = control(replace(plan, template=layer), x, inputs, given)
    radius = max(term.radius for term in layer.feedback_terms)
    taps, steps = _places(layer.feedback_terms, radius)
    drive += sum(float(weight) * _first(term) for term in layer.feedback_terms for *_, weight in term.taps)
    free = np.ones(x.shape, bool) if mask is None else ~np.broadcast_to(mask, state.shape).reshape(grids)
    settles = plan.duration == "settled"
    t = np.inf if settles else float(plan.duration) / float(plan.network.time_constants[0])
    around = pad(inputs, radius, plan.boundary, plan.boundary.u)
    growth, unsure = flow_of_cells(x, drive, free, around, taps, steps, (layer.self_feedback, t))
    error = _ROUNDING * max(1.0, largest(x)) * np.maximum(growth, 1.0)
    unsure |= (np.abs(x) <= error) & (x != 0)
    how = "each cell goes from jump to jump of its drive, exactly"
    return Reached(
        x.reshape(state.shape).astype(where.dtype), float(plan.limit if settles else plan.duration), settles,
        0.0 if settles else float("nan"), max(float(np.finfo(where.dtype).eps), largest(error)),
        unsure.reshape(state.shape), plan, how,
    )  # fmt: skip


def _first(term: Term) -> float:
    assert term.table is not None
    return term.table.values[0]


def _places(terms: tuple[Term, ...], radius: int) -> tuple[Any, Any]:
    """Return the neighbours at whose inputs less an edge drives jump, and (edge, jump, closed), as the loops read them.

    A drive is told from far above all places, where every table has its first value, downwards.
    """
    taps, steps = [], []
    for term in terms:
        table = term.table
        assert table is not None
        for k, l, weight in term.taps:
            for at, low, high in zip(table.at, table.values, table.values[1:], strict=False):
                taps.append((k + radius, l + radius))
                steps.append((at, weight * (high - low), float(table.closed == "left")))
    return np.array(taps), np.array(steps).T.copy()
