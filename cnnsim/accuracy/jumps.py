"""Cells at the edge of a step of their template's tables: there the last digit of the input decides."""

from typing import Any

import numpy as np

from cnnsim.network import Term, pad
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags

_ROUNDINGS = 2.0
"""Of numbers as large as the largest input, that a difference of two of them and the edge of a step have."""


def at_a_jump(plan: Plan, shape: tuple[int, ...], u: Any, dtype: Any) -> Flags | None:
    """Return which cells of a state's shape have an input as near to the edge of a step as numbers of ``dtype`` round.

    An input that lies on an edge is decided, as the definition says on which side, if ``dtype`` holds it as it is.
    None: no term of the input jumps.
    """
    layers = (plan.template,) if plan.network is None else plan.network.layers
    terms = [(n, term) for n, layer in enumerate(layers) for term in layer.control_terms if _edges(term)]
    if not terms or not isinstance(u, np.ndarray):
        return None
    found = np.zeros(shape, bool)
    by_layer = found.reshape(-1, len(layers), *shape[-2:])
    inputs = np.broadcast_to(u, shape).reshape(by_layer.shape).astype(np.float64, copy=False)
    near = _ROUNDINGS * float(np.finfo(dtype).eps) * max(1.0, float(np.abs(u).max(initial=0.0)))
    held = bool((inputs == inputs.astype(dtype)).all())
    for n, term in terms:
        by_layer[:, n] |= _near(plan, term, inputs[:, n], near, held)
    return found


def _edges(term: Term) -> list[float]:
    """Return where the table of a term jumps."""
    table = term.table
    if table is None or table.kind != "step":
        return []
    return [at for at, low, high in zip(table.at, table.values, table.values[1:], strict=False) if low != high]


def _near(plan: Plan, term: Term, u: Array, near: float, held: bool) -> Flags:
    edges, r, (rows, cols) = _edges(term), term.radius, u.shape[-2:]
    found = np.zeros(u.shape, bool)
    values = np.unique(u[:, :2].ravel()[:64])
    if values.size <= 2 and np.isin(u, values).all():  # a black and white picture: few differences to look at
        values = np.union1d(values, [plan.boundary.u])
        few = values if term.of.centre is None else np.subtract.outer(values, values).ravel()
        if not any(_beside(few, edge, near, held).any() for edge in edges):
            return found
    around = pad(u, r, plan.boundary, plan.boundary.u)
    for k, l, _ in term.taps:
        v = around[..., r + k : r + k + rows, r + l : r + l + cols]
        v = v - u if term.of.centre else v
        for edge in edges:
            found |= _beside(v, edge, near, held)
    return found


def _beside(v: Array, edge: float, near: float, held: bool) -> Flags:
    away = np.abs(v - edge)
    return (away <= near) & (away > 0) if held else away <= near
