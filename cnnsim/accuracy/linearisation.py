"""Linearisation of a network of terms at a state: its sparse Jacobian by differences, and the distance to its rest."""

import math
from typing import Any

import numpy as np

from cnnsim.accuracy.linear_rest import is_stable
from cnnsim.accuracy.problem import largest
from cnnsim.accuracy.sparse_solve import MOST_FACTORED, solve_sparse
from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.network import LayeredTemplate, reach
from cnnsim.planning.general import largest_jump
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags, Integers

AT_REST = 1e-13
"""Largest rate that is rounding in float64, for drives of size 1."""
_STEP = 1e-6
"""Change of a state in a difference, which has ten digits then."""
_KINK = 1e-4
"""Difference of two slopes at a state that shows a kink."""
_NEUTRAL = 1e-7
"""A mode slower than this part of the fastest one is constant: its digits are those of the differences."""
_MOST_NUMBERS = 2_000_000
"""Of all changed states together."""


def remaining(plan: Plan, x: Array, planes: Any, mask: Flags | None) -> tuple[float | None, Flags | None]:
    """Return how far a slow state of a network of terms is from its rest, by the rates and their Jacobian.

    It is infinite if a mode grows, or has a constant rate; None if it is not known: a function with jumps, a state
    at a kink, a large grid. The second result marks the cells of an unstable rest in which the state stands still,
    else it is None. Arguments: ``planes`` are input and bias in float64.
    """
    assert plan.network is not None
    if largest_jump(plan.network, plan.characteristic) or x.size > MOST_FACTORED:
        return None, None
    shape = (-1, len(plan.network.layers), *plan.shape)
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
    if (sides := _leaks(plan, network)) is None:
        return None
    above, below = (side[cells][:, cells] for side in sides)
    if abs(above - below).max() > _KINK:
        return None
    leak = (above + below) / 2
    stable = _is_contracting(leak) if plan.cell == "discrete-time" else is_stable(leak, _NEUTRAL)
    if not stable:
        return None if stable is None else math.inf
    step = solve_sparse(leak.tocsc(), rates.ravel()[cells], _STEP)
    return None if step is None else float(np.abs(step).max())


def _rates(network: ReferenceNetwork, x: Array) -> Array:
    """Return dx/dt of states (n, layers, rows, cols), in discrete time the change of the next step."""
    plan, drive = network.plan, network.drive(x, 0)
    if plan.cell == "discrete-time":
        return np.where(network.free, plan.characteristic(drive) - x, 0.0)
    rates = (drive - x) * network.rates
    if plan.cell == "full-range":
        rates[((x >= 1) & (rates > 0)) | ((x <= -1) & (rates < 0))] = 0.0
    return np.where(network.free, rates, 0.0)


def _leaks(plan: Plan, network: ReferenceNetwork) -> list[Any] | None:
    """Return the negative Jacobian of the rates for states that rise and that fall, which differ at a kink.

    Cells too far apart to be read together are changed together. None: that are too many numbers.
    """
    from scipy.sparse import csr_matrix  # slow to import, and only needed here

    assert plan.network is not None
    x, r, periodic = network.x, _radius(plan.network), plan.boundary.kind == "periodic"
    (down, row), (across, col) = (_owners(cells, r, periodic=periodic) for cells in plan.shape)
    layers, rows, cols = x.shape[1:]
    colours = layers * down * across
    if colours * x.size > _MOST_NUMBERS:
        return None
    change = np.zeros((layers, down, across, *x.shape[1:]))
    for layer, a, b in np.ndindex(layers, down, across):
        change[layer, a, b, layer, a::down, b::across] = _STEP
    change = change.reshape(colours, *x.shape[1:])
    there = (row[:, None, :, None] * cols + col[None, :, None, :])[None, :, :, None]  # the changed cell that is near
    near = ((row[:, None, :, None] >= 0) & (col[None, :, None, :] >= 0))[None, :, :, None]
    there = there + rows * cols * np.arange(layers).reshape(-1, 1, 1, 1, 1, 1)
    here, now, found = np.arange(x.size).reshape(layers, rows, cols), _rates(network, x), []
    for side in (1, -1):
        slope = (now - _rates(network, x + side * change)) / (side * _STEP)
        slope = slope.reshape(layers, down, across, layers, rows, cols)
        known = near & (slope != 0)
        at = np.broadcast_to(here, slope.shape)[known], np.broadcast_to(there, slope.shape)[known]
        found.append(csr_matrix((slope[known], at), (x.size, x.size)))
    return found


def _owners(cells: int, r: int, *, periodic: bool) -> tuple[int, Integers]:
    """Return the distance of cells that are changed together, and (distance, cells) which of them a cell can read."""
    apart = next((p for p in range(2 * r + 1, cells) if not periodic or cells % p == 0), cells)
    here = np.arange(cells)
    behind = (here - np.arange(apart)[:, None] + r) % apart
    found = here - behind + r
    if apart == cells:
        return apart, found % cells
    near = (behind <= 2 * r) & (periodic | ((found >= 0) & (found < cells)))
    return apart, np.where(near, found % cells, -1)


def _radius(network: LayeredTemplate) -> int:
    taps = reach((tap.k, tap.l) for layer in network.layers for tap in layer.feedback_taps)
    return max(taps, *(term.radius for layer in network.layers for term in layer.terms), 0)


def _is_contracting(leak: Any) -> bool | None:
    """Return whether no mode of a discrete-time network grows in a step; None if there are too many cells."""
    if leak.shape[0] > 400:
        return None
    return bool(np.abs(1 - np.linalg.eigvals(leak.toarray())).max() <= 1 + _NEUTRAL)
