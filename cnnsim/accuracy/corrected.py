"""A linear template's transient by Runge-Kutta steps whose kinks are corrected, on planes laid out for all runs."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.accuracy.padded import padding
from cnnsim.accuracy.repeatable import Reached, Repeatable, largest
from cnnsim.accuracy.steps import longest_step
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend
from cnnsim.network.weights import reach
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import RK4
from cnnsim.planning.step import check_count
from cnnsim.support import Array, Flags, Floats

MOST_CELLS = 1 << 16
"""Of a grid that one thread takes through its steps; on larger ones the backend is faster."""
USUAL = 2e-3
"""Of an error over (step x norm of A - I)^3: of 64 x 64 random cells half have less."""
SAFE = 4.0
"""How much larger than it is estimated the error may be: of 1200 random transients 1 in 500 had more."""
SAFE_IN_FLIGHT = 20.0
"""The same of two runs whose worst cell is on its way off a ridge: what it missed there has grown ever since."""
_FINE, _LONGEST_FIRST = 2.8, 5.6
"""Steps, times the norm of A - I: two longer ones may err alike where one is not three times as long; the longest."""
APART = 0.4
"""How far apart the outputs of two runs may ever be: where both took the wrong side of a ridge it was 0.45 and more."""
_MIDDLE = 0.4
"""Of the estimate, the error that is usually found."""
_OF_A_PUSH = 0.6
"""Of the difference of two runs from starts pushed this way and that: half is what a push alone makes of a cell."""
_SHORTEST, _LONGEST = 1 / 6, 0.7
"""Of the last step that the next one may be."""
_PATH = 1 << 22
"""Outputs that are kept on the way, of the first steps: it is there that a cell decides."""
_MOST_RUNS, _MOST_FOR_SIGNS = 12, 7
_PLANES = 13


class CorrectedSteps:
    """A transient of a linear template that can be run by one number of steps after another.

    Arguments: its plan, of the method "stepped"; state, input, bias and mask as `Repeatable` has them, of one grid.
    """

    def __init__(self, plan: Plan, planes: tuple[Any, Any, Any, Any]) -> None:
        from cnnsim.accuracy.corrected_loops import corrected_steps, correlated  # numba is slow to import

        state, u, bias, mask = planes
        template, boundary = plan.template, plan.boundary
        self.duration, self._run, self._around = float(plan.duration), corrected_steps, boundary.y
        taps = template.feedback_taps + (template.control_taps if u is not None else ())
        pad = self._padding = padding(state.shape, reach((k, l) for k, l, _ in taps), boundary)
        self._taps, self._real = pad.taps(template.feedback_taps), pad.movable(mask)
        self._planes = np.zeros((_PLANES, self._real.size))
        self._planes[3:10] = self._around  # of virtual cells that are constant
        self._planes[2] = self._real
        drive = self._planes[1]
        pad.real(drive)[...] = template.z if bias is None else template.z + bias
        if u is not None and template.control_taps:
            around = pad.flat(u, boundary.u)
            correlated(around, *pad.taps(template.control_taps), pad.first, pad.last, drive)

    def run(self, state: Array, steps: int) -> Floats:
        """Return the state (rows, cols) after so many steps of one length."""
        return self.taken(state, steps, self.path(0), 1, self.path(0))[0]

    def path(self, steps: int) -> Array:
        """Return where the outputs after each of some steps are kept: of as many as memory is for."""
        cells = self._real.size
        return np.empty((min(steps, _PATH // cells), cells), np.float32)

    def taken(self, state: Array, steps: int, path: Array, every: int, kept: Array) -> tuple[Floats, float]:
        """Return the state after so many steps, and how far its outputs ever were from a path of longer ones.

        ``every`` of these steps are one of the ``path``; the outputs on the way are written to ``kept``.
        """
        pad = self._padding
        self._planes[0] = pad.flat(state, self._around)
        apart = self._run(
            self._planes, self._real, pad.heads, pad.after, *self._taps, pad.virtual, pad.source, pad.first, pad.last,
            self.duration / steps, steps, path, every, kept,
        )  # fmt: skip
        return np.array(pad.real(self._planes[0])), float(apart)


def is_correctable(plan: Plan, shape: tuple[int, ...]) -> bool:
    """Return whether a plan is of a linear template on one grid, of this shape, that is not large."""
    linear = plan.method == "stepped" and plan.cell == "chua-yang" and not plan.template.control_terms
    return linear and len(shape) == 2 and math.prod(shape) <= MOST_CELLS


def is_corrected(transient: Repeatable) -> bool:
    """Return whether a transient is correctable, under an input and a bias that stay."""
    state, u, bias, _ = transient.planes
    stays = all(plane is None or isinstance(plane, np.ndarray) for plane in (u, bias))
    return stays and is_correctable(transient.plan, state.shape)


def first_step(wanted: Wanted) -> float:
    """Return a step, times the norm of A - I, half of which usually is as accurate as that."""
    return float(min(2 * (wanted.error / USUAL) ** (1 / 3), _LONGEST_FIRST))


def by_corrected_steps(transient: Repeatable, where: Backend, wanted: Wanted) -> Reached:
    """Return the end of a transient by shorter and shorter corrected steps, until two runs agree.

    The error of the last run is taken to be its difference to the one before over r^3 - 1, r being the ratio of their
    steps, and no less than what the runs before promise by order 5: two runs may agree by chance. They must agree on
    the way as well: two that pass a ridge on its wrong side end alike, but leave it at different times.
    """
    plan = transient.plan
    steps, duration = CorrectedSteps(plan, transient.planes), float(plan.duration)
    starts = [transient.pushed(where, way) for way in (0.5, -0.5)]  # what rounding decides comes out both ways
    floor = 4 * float(np.finfo(where.dtype).eps) * max(1.0, largest(transient.planes[0]))
    norm = 1.0 + float(np.abs(plan.template.A).sum())
    step = min(first_step(wanted) / norm, longest_step(plan, RK4))
    number = math.ceil(duration / step - 1e-9)
    kept = steps.path(number)
    (before, _), taken = steps.taken(starts[0], number, steps.path(0), 1, kept), [number]
    estimate, done, on_the_way, number = math.inf, False, math.inf, (2 if step * norm < _FINE else 3) * number
    while True:
        check_count(duration, duration / number)
        ratio, together = number / taken[-1], on_the_way <= APART
        path, kept = kept, steps.path(0 if together else number)
        end, way = steps.taken(starts[len(taken) % 2], number, path, round(ratio), kept)
        taken.append(number)
        difference = end - before
        apart = largest(difference)
        on_the_way = max(on_the_way if together else way, apart)
        estimate = floor + max(apart / (ratio**3 - 1), estimate / ratio**5 if estimate < math.inf else 0.0)
        safe = SAFE_IN_FLIGHT if len(taken) == 2 and _in_flight(plan, end, difference) else SAFE
        done = on_the_way <= APART and safe * estimate <= wanted.error
        goal = wanted.error / SAFE
        if wanted.signs:
            unsure = transient.free(_unsure(end, difference, ratio, floor, estimate))
            done = done and not unsure.any()
            nearest = float(np.abs(end)[unsure].min(initial=estimate))
            goal = min(max(nearest, estimate / 64), estimate / 4) if unsure.any() else goal
        if done or len(taken) >= (_MOST_FOR_SIGNS if wanted.signs else _MOST_RUNS) or estimate <= 4 * floor:
            break
        part = (0.6 * goal / estimate) ** (1 / 3) if estimate < math.inf else _SHORTEST
        ratio = 1 / min(max(part, _SHORTEST), _LONGEST)
        # cells on the wrong side of a ridge change it at once, not by the scheme's order
        number = math.ceil(number * ratio) if on_the_way <= APART else 2 * number
        before = end
    if not wanted.signs:
        unsure = transient.free(_unsure(end, difference, ratio, floor, estimate))
    how = (
        f"rk4 with its kinks corrected, by steps of {', '.join(f'{duration / n:.3g}' for n in taken)}; "
        f"the last two runs differ by {apart:.2g}"
    )
    how = how if done else f"{how}; {wanted} was not reached"
    found = replace(plan, scheme=RK4, step=duration / number, savings=frozenset())
    x, error = end.astype(where.dtype, copy=False), _MIDDLE * estimate
    return Reached(x, duration, False, math.nan, error, unsure, found, how)


def _in_flight(plan: Plan, end: Floats, difference: Floats) -> bool:
    """Return whether the cell in which two runs differ most is linear, and drives itself away from where it was."""
    worst = int(np.argmax(np.abs(difference)))
    return plan.template.self_feedback > 1 and abs(float(end.flat[worst])) < 1


def _unsure(end: Floats, difference: Floats, ratio: float, floor: float, estimate: float) -> Flags:
    """Cells whose output may have the other sign: nearer to 0 than the runs differ there, or not finite."""
    moved = np.abs(difference) * max(3 / (ratio**2 - 1), _OF_A_PUSH) + (2 * floor + estimate)
    return ~(np.abs(end) > moved)
