"""Distance of a settled network from its rest: bounded, solved for, or estimated from the decay of its changes.

A small |dx/dt| alone gives no bound: the distance of a mode that decays at the rate s is |dx/dt| / s, and diffusion on
n cells has s = (pi / n)^2. The distance is bounded if A is a contraction, solved for if the template is linear, and
otherwise estimated from the decay of the changes. That estimate misses a mode that grows or a constant rate, both of
which a faster mode may hide, so it counts only if the linearised network has neither.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.solver.linear_rest import find_rest
from cnnsim.solver.linear_system import LinearSystem, linear_system
from cnnsim.solver.linearisation import AT_REST, remaining
from cnnsim.solver.problem import changes, largest, size_of_drives
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

    ``drive`` is w = B*u + z + bias of a linear template, None for others; ``planes`` are input and bias, ``run``
    continues the transient, both in float64.
    """

    plan: Plan
    drive: Floats | None
    planes: tuple[Any, Any]
    mask: Flags | None
    run: Run

    def ending(self, x: Array, t: float, distance: float) -> Ending:
        """Return the rest that a slowly moving state ``x`` approaches, its outputs accurate to ``distance``."""
        moving = np.zeros(x.shape, bool)
        if self.drive is not None:
            found = self._solved(x, t, distance, moving)
            return found if isinstance(found, Ending) else self._decayed(x, t, distance, moving)
        if self.plan.cell == "discrete-time":
            away, _ = remaining(self.plan, x, self.planes, self.mask)
            if away is not None and away <= distance:
                return Ending(x, t, away, moving, f"linearised, the rest is {away:.2g} away")
        return self._decayed(x, t, distance, moving)

    def _solved(self, x: Array, t: float, distance: float, moving: Flags) -> Ending | bool | None:
        """Return the rest found by the linear solver, False if it is far away, None if none is found.

        False as well if cells leave an unstable rest; they are marked in ``moving``.
        """
        assert self.drive is not None
        plan = self.plan
        system = linear_system(plan.template.feedback_taps, plan.shape, plan.boundary)
        end, undecided = x.astype(np.float64), np.zeros(x.shape, bool)
        mask = np.zeros(x.shape, bool) if self.mask is None else self.mask
        planes = (-1, *plan.shape)
        for grid in zip(*(part.reshape(planes) for part in (end, undecided, moving, self.drive, mask)), strict=True):
            if not (found := _solve_grid(system, plan, distance, *grid)):
                return found
        if moving.any():
            return False
        away = float(np.abs(plan.output(end) - plan.output(x.astype(np.float64))).max())
        if undecided.any():
            return _on_separatrix(x, t, undecided)
        if away <= distance:
            return Ending(x, t, away, undecided, f"the rest was solved for: {away:.2g} away")
        return Ending(end, math.inf, float(np.finfo(x.dtype).eps), undecided,
                      f"at |dx/dt| <= {SETTLED_RATE:g} it was {away:.2g} away: solved for")  # fmt: skip

    def _decayed(self, x: Array, t: float, distance: float, moving: Flags) -> Ending:
        """Continue until the changes of three spans, which decay by one factor, add up to less than the distance.

        The linearised network must confirm that no mode grows and no rate is constant. Where it is not known, the run
        continues until the last rate moves no output by half the distance within the plan's limit.
        """
        start, started, separatrix = x, t, moving.copy()
        span, away, before, kept = 5.0, math.inf, math.nan, None
        while t < self.plan.limit:
            after = self.run(x, span)
            moved, x, t = float(np.abs(self.plan.output(after) - self.plan.output(x)).max()), after, t + span
            factor = moved / before if before > 0 else math.nan
            away = moved * factor / (1 - factor) if factor < 1 else 0.0 if moved == 0 else math.inf
            if away <= distance / 2 and kept is None:
                confirmed = self._confirmed(x, t, distance)
                if isinstance(confirmed, Ending):
                    return confirmed
                if confirmed:
                    break
                kept = (x, t, away) if confirmed is None else None
                factor = math.nan if confirmed is None else 1.0
            if kept is not None and moved / span * self.plan.limit <= distance / 2:
                near = np.abs(self.plan.output(x) - self.plan.output(kept[0])).max() <= max(2 * kept[2], distance / 2)
                x, t, away = kept if near else (x, t, moved / span * self.plan.limit)
                break
            if factor > 0.5:
                span, before = 2 * span, math.nan
            else:
                before = moved
        else:
            away = math.inf
        how = f"its changes decay so that {2 * away:.2g} remains" if away < math.inf else "its changes do not decay"
        undecided = separatrix & self._sensitive(start, t - started, x) if separatrix.any() else separatrix
        if undecided.any():
            how = f"{int(undecided.sum())} cells stood on a separatrix, where the smallest perturbation decides; {how}"
        return Ending(x, t, 2 * away, undecided, how)

    def _confirmed(self, x: Array, t: float, distance: float) -> Ending | bool | None:
        """Return whether the linearised network decays to a rest within a distance, None if this is unknown.

        It is an ending where the solved rest is another state, or one on a separatrix.
        """
        if self.drive is None:
            left, undecided = remaining(self.plan, x, self.planes, self.mask)
            if undecided is None:
                return None if left is None else left <= distance
            return _on_separatrix(x, t, undecided)
        found = self._solved(x, t, distance, np.zeros(x.shape, bool))
        return found if not isinstance(found, Ending) or found.x is not x or found.undecided.any() else True

    def _sensitive(self, start: Array, duration: float, end: Array) -> Flags:
        """Return the cells that end with another sign if the start is changed by a hundred roundings up or down."""
        size = 100 * np.finfo(start.dtype).eps * size_of_drives(self.plan, start, *self.planes)
        change = size * changes(start.shape)
        ends = [self.run(start.astype(np.float64) + sign, duration) for sign in (change, -change)]
        return np.logical_or(*((one > 0) != (end > 0) for one in ends))


def _on_separatrix(x: Array, t: float, undecided: Flags) -> Ending:
    return Ending(x, t, 0.0, undecided, f"{int(undecided.sum())} cells stand on a separatrix")


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
    system: LinearSystem, plan: Plan, tolerance: float, x: Any, undecided: Any, moving: Any, drive: Any, mask: Any
) -> bool | None:
    """Write the state at rest over that of one grid; False if it is far away, None if none is found.

    Cells of an unstable rest are marked as ``undecided`` if they stand still but for rounding, else as ``moving``.
    """
    rest = find_rest(system.with_planes(drive.ravel(), ~mask.ravel()), x.ravel(), tolerance)
    if rest is None or rest.stable is None:
        return None if rest is None else False
    if rest.stable:
        state = rest.y if plan.cell == "full-range" else rest.drive
        x[~mask] = state.reshape(x.shape)[~mask]
    else:
        y = x.ravel().clip(-1, 1)
        rates = (system.matrix @ y + system.drive + drive.ravel()).clip(-1, 1) - y
        still = largest(rates[rest.linear]) <= AT_REST * max(1.0, largest(rest.drive))
        (undecided if still else moving)[...] = rest.linear.reshape(x.shape)
    return True
