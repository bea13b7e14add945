"""Settling with a promise: how far from its end a network is whose rate is small, and the rest of the way if too far.

A small rate says little: of a mode that decays at the rate s the distance left is |dx/dt| / s, and diffusion on n cells
has s = (pi / n)^2. The distance is bounded where A is a contraction, solved for where the template is linear, and
estimated from the decay of the changes where neither will do.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cnnsim.accuracy.linear.rest import Rest, find_rest
from cnnsim.accuracy.linear.system import LinearSystem, linear_system
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array, Flags, Floats

SETTLED_DISTANCE = 1e-3
"""How far an output may be from its end in a network that is called settled, unless an accuracy is asked for."""

_SOLVING, _SOLVING_A_TAP = 150, 65
"""Bytes a cell of the planes and the sparse matrix with which a rest is solved for, found by tracemalloc."""

Run = Callable[[Array, float], Array]
"""(state, duration) -> state: goes on with the transient for so many time constants."""


class Ending(NamedTuple):
    """How a transient that came to rest ends: its state, the time, the largest distance of an output from the end.

    ``undecided`` marks the cells on a ridge, where the smallest push decides; ``how`` the distance is known, in words.
    A ``distance`` that is more than was promised: it never came to rest.
    """

    x: Any
    t: float
    distance: float
    undecided: Flags
    how: str


@dataclass(frozen=True)
class Settling:
    """A plan whose network has settled by its rate, and what is needed to see how far it is from the end.

    ``drive`` is w = B*u + z + bias of a linear template, None for others; ``run`` goes on with the transient.
    """

    plan: Plan
    drive: Floats | None
    mask: Flags | None
    run: Run

    def end(self, x: Array, t: float, rate: float, promise: float) -> Ending:
        """Return how the transient ends from a state that hardly moves, with its outputs within ``promise``."""
        ridge = np.zeros(x.shape, bool)
        return self._solved(x, t, rate, promise, ridge) or self._decayed(x, t, promise, ridge)

    def _held(self, x: Array) -> Flags:
        return np.zeros(x.shape, bool) if self.mask is None else self.mask

    def _solved(self, x: Array, t: float, rate: float, promise: float, ridge: Flags) -> Ending | None:
        """Return the end that is solved for, None where it cannot be told; cells on a ridge are marked in ``ridge``."""
        if self.drive is None:
            return None
        plan = self.plan
        system = linear_system(plan.template.feedback_taps, plan.shape, plan.boundary)
        end, undecided = x.astype(np.float64), np.zeros(x.shape, bool)
        planes = (-1, *plan.shape)
        for grid in zip(*(part.reshape(planes) for part in (end, undecided, self.drive, self._held(x))), strict=True):
            if not _rest_of_grid(system, plan, promise, *grid):
                return None
        distance = float(np.abs(plan.output(end) - plan.output(x.astype(np.float64))).max())
        if undecided.any() and rate > 100 * np.finfo(x.dtype).eps:
            ridge[...] = undecided
            return None  # it has begun to leave the ridge
        if undecided.any():
            return Ending(x, t, 0.0, undecided, f"{int(undecided.sum())} cells stand on a ridge")
        if distance <= promise:
            return Ending(x, t, distance, undecided, f"the rest was solved for: {distance:.2g} away")
        return Ending(end, math.inf, float(np.finfo(x.dtype).eps), undecided,
                      f"at |dx/dt| <= {SETTLED_RATE:g} it was {distance:.2g} away: solved for")  # fmt: skip

    def _decayed(self, x: Array, t: float, promise: float, ridge: Flags) -> Ending:
        """Go on until the changes of three spans, which decay by the same factor, add up to less than the promise.

        Changes near a ridge decay first and then grow: its cells are followed until they have left it, and named.
        """
        start, begun = x, t
        span, distance, before = 5.0, math.inf, math.nan
        while t < self.plan.limit:
            after = self.run(x, span)
            moved, x, t = float(np.abs(self.plan.output(after) - self.plan.output(x)).max()), after, t + span
            factor = moved / before if before > 0 else math.nan
            distance = moved * factor / (1 - factor) if factor < 1 else 0.0 if moved == 0 else math.inf
            if distance <= promise / 2 and not (ridge & (np.abs(x) < 1)).any():  # many modes decay ever more slowly
                break
            if factor > 0.5:
                span, before = 2 * span, math.nan
            else:
                before = moved
        how = f"its changes decay so that {2 * distance:.2g} is left"
        ridge = ridge & self._ties(start, t - begun, x) if ridge.any() else ridge
        if ridge.any():
            how = f"{int(ridge.sum())} cells stood on a ridge, where the smallest push decides; {how}"
        return Ending(x, t, 2 * distance, ridge, how)

    def _ties(self, start: Array, duration: float, end: Array) -> Flags:
        """Return the cells that end with another sign after pushes of a hundred roundings this way or that."""
        push = 100 * np.finfo(start.dtype).eps * np.random.default_rng(0).choice([-1.0, 1.0], start.shape)
        ends = [self.run(start.astype(np.float64) + way, duration) for way in (push, -push)]
        return np.logical_or(*((one > 0) != (end > 0) for one in ends))


def solving_bytes(plan: Plan) -> int:
    """Return the bytes a cell that it takes to solve for a rest with outputs that are not saturated."""
    return _SOLVING + _SOLVING_A_TAP * len(plan.template.feedback_taps)


def contraction_bound(plan: Plan, rate: float) -> float:
    """Return |dx/dt| / (1 - sum|A|), which no output is farther from its end; infinite if A is no contraction."""
    if plan.method != "stepped":
        return math.inf
    gap = 1.0 - float(np.abs(plan.template.A).sum())
    return rate / gap if gap > 0 else math.inf


def _rest_of_grid(
    system: LinearSystem, plan: Plan, promise: float, x: Any, undecided: Any, drive: Any, held: Any
) -> bool:
    """Write the state at rest over that of one grid, and mark the cells on a ridge; False if it cannot be told."""
    rest: Rest | None = find_rest(
        system.with_planes(drive.ravel(), ~held.ravel()), x.ravel(), promise
    )  # fmt: skip
    if rest is None:
        return False
    if rest.stable:
        state = rest.y if plan.cell == "full-range" else rest.drive
        x[~held] = state.reshape(x.shape)[~held]
    else:
        undecided[...] = rest.linear.reshape(x.shape)
    return True
