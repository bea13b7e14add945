"""Steps of a linear template: by a Runge-Kutta scheme of any stages, masks and limits, or by the fused Euler method.

Where the fused Euler method (`euler`) does not apply, the padded outputs of each stage are summed row by row.
"""

from typing import NamedTuple

import numba
import numpy as np
from numba import prange

from cnnsim.backends.base import Check, Outcome, Stepper
from cnnsim.backends.cpu.boundary import VirtualCells, fill_virtual
from cnnsim.backends.cpu.euler.dense import dense
from cnnsim.backends.cpu.euler.part import over_part
from cnnsim.backends.cpu.euler.position import END, PHASE, START
from cnnsim.backends.cpu.euler.settled import FIGURES
from cnnsim.backends.cpu.euler.sleep import COLUMNS, sleeping
from cnnsim.backends.cpu.euler.window import window
from cnnsim.backends.cpu.jit.compile import helper, threads_for, twins
from cnnsim.backends.cpu.planes import all_true, clip_row, copy_row, grids, largest_of
from cnnsim.backends.cpu.pool import Pool
from cnnsim.backends.cpu.prepared import Prepared
from cnnsim.backends.cpu.settled import check_row
from cnnsim.backends.slices import PIECE, Pace
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array


class SchemeTable(NamedTuple):
    """A scheme's table times its gain, ``a`` (stages, stages) and ``b``; ``limited``: stages end within +-1."""

    a: Array
    b: Array
    limited: bool


class Scratch(NamedTuple):
    """Planes of the stages: outputs with virtual cells, the stage (the first is the state itself: of a scheme of one,
    no grid), the rates of all stages; and a check, row by row.
    """

    padded: Array
    stage: Array
    rates: Array
    largest: Array
    saturated: Array


@helper
def add_taps(total: Array, padded: Array, taps: Array, i: int, r: int) -> None:
    """Add the taps' weighted neighbours of row i of one grid to ``total``."""
    cols = total.size
    for tap in range(taps.size):
        first = r + taps[tap]["l"]
        line = padded[i + r + taps[tap]["k"], first : first + cols]
        c = taps[tap]["weight"]
        for j in range(cols):
            total[j] += c * line[j]


@twins
def run_stages(
    planes: tuple[Array, Array, Array], taps: Array, virtual: VirtualCells, scheme: SchemeTable, scratch: Scratch,
    count: int, begin: int, end: int,
) -> tuple[float, bool]:  # fmt: skip
    """Take ``count`` steps on x in place; for 0 steps check x, and leave the rates of the first stage.

    ``planes`` are x, w and the mask (no cells: none); the first step begins with stage ``begin``, as the rates of those
    before it are there, and the last one goes up to stage ``end``, if that is not the last one without the step itself.
    Returns the largest |dx/dt|, and whether all cells are saturated. One loop for all, because it is long to compile.
    """
    x, w, mask = planes
    ha, hb, limited = scheme
    padded, stage, rates, largest, saturated = scratch
    n, height, width = x.shape
    r = virtual[2]
    for number in range(max(count, 1)):
        for i in range(begin if number == 0 else 0, end if number == count - 1 else hb.size if count else 1):
            at = stage if i else x  # the first stage is the state itself
            for line in prange(n * height):
                g, p = line // height, line % height
                row = at[g, p]
                if i:
                    copy_row(x[g, p], row)
                for earlier in range(i):
                    c = ha[i, earlier]
                    for j in range(width):
                        row[j] += c * rates[earlier, g, p, j]
                if limited and i:
                    clip_row(row, row)
                clip_row(row, padded[g, p + r, r : r + width])
            for g in prange(n):
                fill_virtual(padded[g], virtual)
            for line in prange(n * height):
                g, p = line // height, line % height
                row = rates[i, g, p]
                copy_row(w[g, p], row)
                add_taps(row, padded[g], taps, p, r)
                if count == 0:
                    of_row = mask[g, p] if mask.size else mask[0, 0]
                    largest[line], saturated[line] = check_row(row, x[g, p], of_row, limited)
                for j in range(width):
                    row[j] -= at[g, p, j]
                if mask.size:  # held in the stages, too: their neighbours see the stages
                    for j in range(width):
                        if mask[g, p, j]:
                            row[j] = 0
        if count == 0 or (number == count - 1 and end < hb.size):
            break
        for line in prange(n * height):
            g, p = line // height, line % height
            row = x[g, p]
            if mask.size:
                for j in range(width):
                    if not mask[g, p, j]:
                        v = row[j]
                        for i in range(hb.size):
                            v += hb[i] * rates[i, g, p, j]
                        row[j] = v
            else:
                for i in range(hb.size):
                    c = hb[i]
                    for j in range(width):
                        row[j] += c * rates[i, g, p, j]
            if limited:
                clip_row(row, row)
    return largest_of(largest), all_true(saturated)


class CompiledSteps(Stepper):
    """Steps of a linear template; the full-range model ends every stage within +-1. A mask without cells holds none."""

    def __init__(self, plan: Plan, ready: Prepared, x: Array, w: Array, mask: Array) -> None:
        self._x, self._saturation_ends, self._checked = x.copy(), plan.saturation_ends, False
        self._stages = len(ready.scheme[1])
        work = x.size * len(plan.feedback_taps)
        self._run, self.work = run_stages.for_work(work), work * self._stages
        r, (n, rows, cols) = ready.around_y[2], grids(x).shape
        stages, lines = self._stages, n * rows
        scratch = Scratch(
            np.empty((n, rows + 2 * r, cols + 2 * r), x.dtype), np.empty((n if stages > 1 else 0, rows, cols), x.dtype),
            np.empty((stages, n, rows, cols), x.dtype), np.zeros(lines, x.dtype), np.zeros(lines, bool),
        )  # fmt: skip
        planes = grids(self._x), grids(w), mask
        self._given = planes, ready.feedback_taps, ready.around_y, ready.scheme, tuple(scratch)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        rate, saturated = self._run(*self._given, 0, 0, 1)
        self._checked = True
        return Check(float(rate), self._saturation_ends and bool(saturated))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        begin, self._checked = int(self._checked), False
        if self.work <= PIECE or self._stages == 1:
            self._run(*self._given, count, begin, self._stages)
            return
        for _ in range(count):  # stage by stage, so that Python can hear a signal
            for stage in range(begin, self._stages):
                self._run(*self._given, 1, stage, stage + 1)
            begin = 0

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._x


def fused_euler(plan: Plan, ready: Prepared, x: Array, w: Array, pool: Pool) -> Outcome:
    """Run a transient by Euler steps, several a pass over the grid, in slices."""
    work, sleeps = x.size * len(plan.feedback_taps), "sleep" in plan.savings
    planes = x, pool.plane(x), pool.plane(x)
    threads = threads_for(work)
    given = (*map(grids, planes), grids(w)), ready.feedback, (*ready.tiles, threads), ready.schedule
    known = np.empty((len(given[0][0]) * ready.tile_count, COLUMNS) if sleeps else (threads, FIGURES))
    run = (sleeping if sleeps else dense).for_work(work)
    position, settled, rate = run(*given, known, START, ready.first_slice)
    if position[PHASE] != END:
        pace = Pace(plan, ready.tile_work)
        while position[PHASE] != END:
            position, settled, rate = run(*given, known, position, pace.left)
            pace.turn(position[0], rate)
        pace.over()
    done, where = position[:2]
    end = x.copy() if where == 0 else planes[where]
    pool.keep(*(plane for plane in planes[1:] if plane is not end))
    return Outcome(end, done * plan.step if ready.settles else ready.t, bool(settled), float(rate))


def over_area(
    plan: Plan, ready: Prepared, x: Array, target: Array, w: Array, area: tuple[tuple[int, int], tuple[int, int]],
    task: int, behind: int,
) -> Check:  # fmt: skip
    """Check, or catch up, the cells of an area (see `euler.window`), by the arithmetic of the fused Euler method."""
    planes = grids(x), grids(target), grids(w)
    address = window(numba.typeof(ready.feedback)).address
    rate, saturated, (r0, r1, c0, c1) = over_part.serial(
        planes, ready.feedback, int(address), (*area[0], *area[1]), task, behind, SETTLED_RATE
    )
    moving = None if saturated or not plan.saturation_ends else ((r0, r1), (c0, c1))
    return Check(float(rate), plan.saturation_ends and bool(saturated), moving=moving)
