"""Linearisation of a network of terms at a state: its Jacobian by differences, and the distance to its rest."""

import math
from typing import Any

import numpy as np

from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.planning.general import largest_jump
from cnnsim.planning.plan import Plan
from cnnsim.solver.linear_rest import is_stable
from cnnsim.solver.problem import largest
from cnnsim.solver.sparse_solve import solve_sparse
from cnnsim.support import Array, Flags, Floats, Integers

AT_REST = 1e-13
"""Largest rate that is rounding in float64, for drives of size 1."""
_STEP = 1e-6
"""Change of a state in a difference, which has ten digits then."""
_KINK = 1e-4
"""Difference of two slopes at a state that shows a kink."""
_NEUTRAL = 1e-7
"""A mode slower than this part of the fastest one is constant: its digits are those of the differences."""
_MOST_CELLS = 1024
"""Of a network that is linearised, in a fraction of a second."""


def remaining(plan: Plan, x: Array, planes: Any, mask: Flags | None) -> tuple[float | None, Flags | None]:
    """Return how far a slow state of a network of terms is from its rest, by the rates and their Jacobian.

    It is infinite if a mode grows, or has a constant rate; None if it is not known: a function with jumps, a state
    at a kink, a large grid. The second result marks the cells of an unstable rest in which the state stands still,
    else it is None. Arguments: ``planes`` are input and bias in float64.
    """
    assert plan.network is not None
    shape = (-1, len(plan.network.layers), *plan.shape)
    if largest_jump(plan.network, plan.characteristic) or math.prod(shape[1:]) > _MOST_CELLS:
        return None, None
    parts = [None if plane is None else plane.reshape(shape) for plane in (*planes, mask)]
    furthest, unstable, still = 0.0, np.zeros(x.shape, bool), True
    for number, state in enumerate(x.reshape(shape)):
        u, bias, held = (None if part is None else part[number] for part in parts)
        network = ReferenceNetwork(plan, state.astype(np.float64), u, bias, held)
        rates, found = _rates(network, network.x), _of_grid(plan, network)
        if found is None:
            return None, None
        furthest = max(furthest, found)
        if found == math.inf:
            still &= largest(rates) <= AT_REST * max(1.0, largest(state))
            unstable.reshape(shape)[number] = network.free[0] & (np.abs(state) < 1)
    return furthest, unstable if still and furthest == math.inf else None


def _of_grid(plan: Plan, network: ReferenceNetwork) -> float | None:
    x, rates = network.x, _rates(network, network.x)
    free = network.free & ~((plan.cell == "full-range") & (rates == 0) & (np.abs(x) >= 1))
    cells = np.flatnonzero(free)
    if not cells.size:
        return 0.0
    above, below = (_leak(network, cells, step) for step in (_STEP, -_STEP))
    if np.abs(above - below).max() > _KINK:
        return None
    from scipy.sparse import csc_matrix  # slow to import, and only needed here

    leak = csc_matrix((above + below) / 2)
    if plan.cell == "discrete-time":
        stable: bool | None = bool(np.abs(1 - np.linalg.eigvals(leak.toarray())).max() <= 1 + _NEUTRAL)
    else:
        stable = is_stable(leak, _NEUTRAL)
    if not stable:
        return None if stable is None else math.inf
    step = solve_sparse(leak, rates.ravel()[cells], _STEP)
    return None if step is None else largest(step)


def _rates(network: ReferenceNetwork, x: Array) -> Array:
    """Return dx/dt of states (n, layers, rows, cols), in discrete time the change of the next step."""
    plan, drive = network.plan, network.drive(x, 0)
    if plan.cell == "discrete-time":
        return np.where(network.free, plan.characteristic(drive) - x, 0.0)
    rates = (drive - x) * network.rates
    if plan.cell == "full-range":
        rates[((x >= 1) & (rates > 0)) | ((x <= -1) & (rates < 0))] = 0.0
    return np.where(network.free, rates, 0.0)


def _leak(network: ReferenceNetwork, cells: Integers, step: float) -> Floats:
    """Return the negative Jacobian (cells, cells) of the rates of some cells, each of which is changed by a step."""
    x = network.x
    changed = np.repeat(x.reshape(1, -1), cells.size, axis=0)
    changed[np.arange(cells.size), cells] += step
    rates = _rates(network, changed.reshape(-1, *x.shape[1:])) - _rates(network, x)
    return -rates.reshape(cells.size, -1)[:, cells].T / step
