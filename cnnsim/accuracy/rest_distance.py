"""Distance of a settled network from its rest: bounded, solved for, or estimated from the decay of its changes.

A small |dx/dt| alone gives no bound: the distance of a mode that decays at the rate s is |dx/dt| / s, and diffusion on
n cells has s = (pi / n)^2. The distance is bounded if A is a contraction, solved for if the template is linear, and
otherwise estimated from the decay of the changes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cnnsim.accuracy.linear_rest import find_rest
from cnnsim.accuracy.linear_system import LinearSystem, linear_system
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array, Flags, Floats

SETTLED_DISTANCE = 1e-3
"""Largest distance of an output from its rest in a settled network, unless an accuracy is given."""

_SOLVING, _SOLVING_A_TAP = 150, 65
"""Bytes a cell of the planes and the sparse matrix with which a rest is solved for, found by tracemalloc."""

Run = Callable[[Array, float], Array]
"""(state, duration) -> state: continues the transient for some time constants."""


class Ending(NamedTuple):
    """The rest of a transient: its state, the time, the largest distance of an output from it.

    ``undecided`` marks the cells on a separatrix, where the smallest perturbation decides. ``how`` describes how the
    distance was found. If ``distance`` is above the one requested, the transient has not settled.
    """

    x: Any
    t: float
    distance: float
    undecided: Flags
    how: str


@dataclass(frozen=True)
class SettledState:
    """A plan whose network has a small rate, with the data to find its distance from the rest.

    ``drive`` is w = B*u + z + bias of a linear template, None for others; ``run`` continues the transient.
    """

    plan: Plan
    drive: Floats | None
    mask: Flags | None
    run: Run

    def ending(self, x: Array, t: float, rate: float, distance: float) -> Ending:
        """Return the rest that a state ``x`` with a small ``rate`` approaches, its outputs accurate to ``distance``."""
        separatrix = np.zeros(x.shape, bool)
        return self._solved(x, t, rate, distance, separatrix) or self._decayed(x, t, distance, separatrix)

    def _solved(self, x: Array, t: float, rate: float, distance: float, separatrix: Flags) -> Ending | None:
        """Return the rest found by the linear solver, else None; marks the cells on a separatrix in ``separatrix``."""
        if self.drive is None:
            return None
        plan = self.plan
        system = linear_system(plan.template.feedback_taps, plan.shape, plan.boundary)
        end, undecided = x.astype(np.float64), np.zeros(x.shape, bool)
        mask = np.zeros(x.shape, bool) if self.mask is None else self.mask
        planes = (-1, *plan.shape)
        for grid in zip(*(part.reshape(planes) for part in (end, undecided, self.drive, mask)), strict=True):
            if not _solve_grid(system, plan, distance, *grid):
                return None
        away = float(np.abs(plan.output(end) - plan.output(x.astype(np.float64))).max())
        if undecided.any() and rate > 100 * np.finfo(x.dtype).eps:
            separatrix[...] = undecided
            return None  # the state leaves the separatrix
        if undecided.any():
            return Ending(x, t, 0.0, undecided, f"{int(undecided.sum())} cells stand on a separatrix")
        if away <= distance:
            return Ending(x, t, away, undecided, f"the rest was solved for: {away:.2g} away")
        return Ending(end, math.inf, float(np.finfo(x.dtype).eps), undecided,
                      f"at |dx/dt| <= {SETTLED_RATE:g} it was {away:.2g} away: solved for")  # fmt: skip

    def _decayed(self, x: Array, t: float, distance: float, separatrix: Flags) -> Ending:
        """Continue until the changes of three spans, which decay by one factor, add up to less than the distance.

        Changes near a separatrix decay first and then grow: its cells are followed until they have left it, and named.
        """
        start, started = x, t
        span, away, before = 5.0, math.inf, math.nan
        while t < self.plan.limit:
            after = self.run(x, span)
            moved, x, t = float(np.abs(self.plan.output(after) - self.plan.output(x)).max()), after, t + span
            factor = moved / before if before > 0 else math.nan
            away = moved * factor / (1 - factor) if factor < 1 else 0.0 if moved == 0 else math.inf
            if away <= distance / 2 and not (separatrix & (np.abs(x) < 1)).any():  # slower modes decay later
                break
            if factor > 0.5:
                span, before = 2 * span, math.nan
            else:
                before = moved
        how = f"its changes decay so that {2 * away:.2g} remains"
        undecided = separatrix & self._sensitive(start, t - started, x) if separatrix.any() else separatrix
        if undecided.any():
            how = f"{int(undecided.sum())} cells stood on a separatrix, where the smallest perturbation decides; {how}"
        return Ending(x, t, 2 * away, undecided, how)

    def _sensitive(self, start: Array, duration: float, end: Array) -> Flags:
        """Return the cells that end with another sign if the start is changed by a hundred roundings up or down."""
        change = 100 * np.finfo(start.dtype).eps * np.random.default_rng(0).choice([-1.0, 1.0], start.shape)
        ends = [self.run(start.astype(np.float64) + sign, duration) for sign in (change, -change)]
        return np.logical_or(*((one > 0) != (end > 0) for one in ends))


def solving_bytes(plan: Plan) -> int:
    """Return the bytes a cell needed to solve for a rest with outputs that are not saturated."""
    return _SOLVING + _SOLVING_A_TAP * len(plan.template.feedback_taps)


def contraction_bound(plan: Plan, rate: float) -> float:
    """Return |dx/dt| / (1 - sum|A|), the largest distance of an output; infinite if A is no contraction."""
    if plan.method != "stepped":
        return math.inf
    gap = 1.0 - float(np.abs(plan.template.A).sum())
    return rate / gap if gap > 0 else math.inf


def _solve_grid(
    system: LinearSystem, plan: Plan, tolerance: float, x: Any, undecided: Any, drive: Any, mask: Any
) -> bool:
    """Write the state at rest over that of one grid, and mark the cells on a separatrix; False if none is found."""
    rest = find_rest(system.with_planes(drive.ravel(), ~mask.ravel()), x.ravel(), tolerance)
    if rest is None:
        return False
    if rest.stable:
        state = rest.y if plan.cell == "full-range" else rest.drive
        x[~mask] = state.reshape(x.shape)[~mask]
    else:
        undecided[...] = rest.linear.reshape(x.shape)
    return True
