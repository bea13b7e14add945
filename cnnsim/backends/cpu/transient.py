"""Steps of a linear template by tiles: by a Runge-Kutta scheme of any stages, with masks and limits, in slices."""

import numba
import numpy as np

from cnnsim.backends.base import Check, Outcome
from cnnsim.backends.cpu.jit.compile import threads_for
from cnnsim.backends.cpu.planes import grids
from cnnsim.backends.cpu.pool import Pool
from cnnsim.backends.cpu.prepared import Prepared
from cnnsim.backends.cpu.tiles.dense import dense
from cnnsim.backends.cpu.tiles.grid import Schedule
from cnnsim.backends.cpu.tiles.part import over_part
from cnnsim.backends.cpu.tiles.position import END, PHASE, START
from cnnsim.backends.cpu.tiles.settled import FIGURES, UNSATURATED
from cnnsim.backends.cpu.tiles.sleep import COLUMNS, sleeping
from cnnsim.backends.cpu.tiles.window import window
from cnnsim.backends.slices import Pace
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array


def by_tiles(plan: Plan, ready: Prepared, x: Array, w: Array, mask: Array | None, pool: Pool) -> Outcome:
    """Run a transient, several steps or stages a pass over the grid, in slices; ``mask``: its words."""
    tiled = ready.tiled if mask is None else ready.masked
    work, sleeps = x.size * len(plan.feedback_taps), tiled.sleeps
    planes = x, pool.plane(x), pool.plane(x)
    threads, (cells, *others) = threads_for(work), map(grids, planes)
    words = np.empty((len(cells), 0, 0), np.uint64) if mask is None else mask
    given = (cells, *others, grids(w), words), tiled.feedback, (*tiled.tiles, threads), ready.schedule
    known = np.empty((len(cells) * tiled.count, COLUMNS) if sleeps else (threads, FIGURES))
    run = (sleeping if sleeps else dense).for_work(work)
    position, settled, rate = run(*given, known, START, tiled.first_slice)
    if position[PHASE] != END:
        pace = Pace(plan, tiled.work)
        while position[PHASE] != END:
            position, settled, rate = run(*given, known, position, pace.left)
            pace.turn(position[0], rate)
        pace.over()
    done, where = position[:2]
    end = x.copy() if where == 0 else planes[where]
    pool.keep(*(plane for plane in planes[1:] if plane is not end))
    return Outcome(end, done * plan.step if ready.settles else ready.t, bool(settled), float(rate))


def check_free(plan: Plan, ready: Prepared, x: Array, w: Array, mask: Array) -> Check:
    """Check the cells that a mask does not hold, as they are checked before a step."""
    tiled, work = ready.masked, x.size * len(plan.feedback_taps)
    threads, cells = threads_for(work), grids(x)
    known, schedule = np.empty((threads, FIGURES)), tuple(Schedule(0, 1, SETTLED_RATE, plan.saturation_ends))
    planes = cells, cells, cells, grids(w), mask  # nothing is stepped
    _, _, rate = dense.for_work(work)(
        planes, tiled.feedback, (*tiled.tiles, threads), schedule, known, START, tiled.work * len(cells) * tiled.count
    )
    return Check(float(rate), plan.saturation_ends and not known[:, UNSATURATED].any())


def over_area(
    plan: Plan, ready: Prepared, x: Array, target: Array, w: Array, area: tuple[tuple[int, int], tuple[int, int]],
    task: int, behind: int,
) -> Check:  # fmt: skip
    """Check, or catch up, the cells of an area (see `tiles.window`), by the arithmetic of the fused Euler method."""
    planes = grids(x), grids(target), grids(w)
    address = window(numba.typeof(ready.tiled.feedback)).address
    rate, saturated, (r0, r1, c0, c1) = over_part.serial(
        planes, ready.tiled.feedback, int(address), (*area[0], *area[1]), task, behind, SETTLED_RATE
    )
    moving = None if saturated or not plan.saturation_ends else ((r0, r1), (c0, c1))
    return Check(float(rate), plan.saturation_ends and bool(saturated), moving=moving)
