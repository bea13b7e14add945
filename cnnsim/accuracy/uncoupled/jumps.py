"""Cells at the edge of a step of their template's tables: there the last digit of the input decides by how much."""

from typing import Any

import numpy as np

from cnnsim.network import Term, pad
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Floats

_ROUNDINGS = 2.0
"""Of numbers as large as the largest input, that a difference of two of them and the edge of a step have."""


def jumps_of_last_digits(plan: Plan, shape: tuple[int, ...], u: Any, dtype: Any) -> Floats | None:
    """Return by how much the drive of each cell changes at most if inputs at the edge of a step lie beyond it.

    An input is at an edge if it is as near as numbers of ``dtype`` round; one that lies on it is decided, as the
    definition says on which side, if ``dtype`` holds it as it is. ``shape`` is the state's. None: nowhere.
    """
    layers = (plan.template,) if plan.network is None else plan.network.layers
    terms = [(n, term) for n, layer in enumerate(layers) for term in layer.control_terms if _edges(term)[0]]
    if not terms or not isinstance(u, np.ndarray):
        return None
    found = np.zeros(shape)
    by_layer = found.reshape(-1, len(layers), *shape[-2:])
    inputs = np.broadcast_to(u, shape).reshape(by_layer.shape).astype(np.float64, copy=False)
    near = _ROUNDINGS * float(np.finfo(dtype).eps) * max(1.0, float(np.abs(u).max(initial=0.0)))
    held = bool((inputs == inputs.astype(dtype)).all())
    at_one = [_add_jumps(plan, term, inputs[:, n], near, held, by_layer[:, n]) for n, term in terms]
    return found if any(at_one) else None


def _edges(term: Term) -> tuple[list[float], list[float]]:
    """Return where the table of a term jumps, and by how much."""
    table = term.table
    if table is None or table.kind != "step":
        return [], []
    steps = zip(table.at, table.values, table.values[1:], strict=False)
    jumps = [(at, abs(high - low)) for at, low, high in steps if low != high]
    return [at for at, _ in jumps], [size for _, size in jumps]


def _add_jumps(plan: Plan, term: Term, u: Floats, near: float, held: bool, total: Any) -> bool:
    """Add the jumps of one term on planes (n, rows, cols); return whether there are any."""
    from cnnsim.accuracy.uncoupled.jump_loops import add_jumps  # numba is slow to import

    edges, sizes = _edges(term)
    values = np.unique(u[:, :2].ravel()[:64])
    if values.size <= 2 and np.isin(u, values).all():  # a black and white picture: few differences to look at
        values = np.union1d(values, [plan.boundary.u])
        few = values if term.of.centre is None else np.subtract.outer(values, values).ravel()
        if not any(_beside(few, edge, near, held).any() for edge in edges):
            return False
    factor = 1.0 if term.times is None else 2.0 * max(1.0, float(np.abs(u).max(initial=0.0)))
    places = np.array([(k, l) for k, l, _ in term.taps])
    weights = factor * np.array([float(np.abs(weight).max()) for *_, weight in term.taps])
    around = pad(u, term.radius, plan.boundary, plan.boundary.u)
    how = (5e-324 if held else 0.0, near, 0.0 if term.of.centre is None else 1.0)
    return bool(add_jumps(around, term.radius + places, weights, np.array([edges, sizes]), how, term.radius, total))


def _beside(v: Array, edge: float, near: float, held: bool) -> Array:
    away = np.abs(v - edge)
    return (away <= near) & (away > 0) if held else away <= near
