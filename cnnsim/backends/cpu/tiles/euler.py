"""Euler steps of a linear template by tiles: the constants of the loops, and a transient in slices of time.

Steps of several stages, masks and limited states are those of `network`.
"""

import math
from functools import cached_property
from typing import Any

import numba
import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.backends.codes import boundary_code
from cnnsim.backends.cpu.compiled import Kernel, tap_records, threads_for
from cnnsim.backends.cpu.planes import Pool, grids
from cnnsim.backends.cpu.tiles import rows
from cnnsim.backends.cpu.tiles.dense import START, dense
from cnnsim.backends.cpu.tiles.grid import Feedback, Schedule
from cnnsim.backends.cpu.tiles.sleep import COLUMNS, sleeping
from cnnsim.backends.cpu.tiles.stream import streaming
from cnnsim.backends.cpu.tiles.window import HEIGHT, WIDTH, window
from cnnsim.backends.slices import Pace
from cnnsim.network import reach
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array

TILE_ROWS, TILE_COLS = 512, 1024
"""The most rows and columns of a tile; with `plan.MOST_HALO` on both sides a row fits a row of a buffer."""


class EulerTiles:
    """Euler steps of one plan, in one dtype, for one number of threads."""

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        assert plan.scheme is not None
        r = max(reach((tap.k, tap.l) for tap in plan.feedback_taps), 1)  # the loops over rows take a radius of 1
        self._loop, self._dtype, self._sleeps = loop_kind(plan, r, dtype), dtype, "sleep" in plan.savings
        boundary, h = plan.boundary, dtype.type(plan.scheme.gain(plan.step))
        self._numbers = (
            tap_records(plan.feedback_taps, dtype), square(plan, dtype), h, r, int(boundary_code(boundary)),
            dtype.type(boundary.y),
        )  # fmt: skip
        self._settles = plan.duration == "settled"
        every = plan.check_every if self._settles else 0
        self._schedule = tuple(Schedule(plan.steps, every, dtype.type(SETTLED_RATE), plan.saturation_ends))
        shape = tile_shape(plan, threads, widest(plan.depth * r))
        self._tile = plan.depth, *shape
        height, width = (HEIGHT, WIDTH) if self._sleeps else shape
        self._count = -(-plan.shape[0] // height) * -(-plan.shape[1] // width)
        self._work = height * width * max(1, len(plan.feedback_taps))
        self._first_slice = Pace(plan, self._work).left

    @cached_property
    def _compiled(self) -> tuple[Any, Any]:
        """The feedback, and the `Tiling` without the threads; made at the first run, because it compiles the loops."""
        feedback = tuple(Feedback(rows.loop(self._loop, self._dtype).address, *self._numbers))
        step = (window if self._sleeps else streaming)(numba.typeof(feedback))
        return feedback, (int(step.address), *self._tile)

    def run(self, plan: Plan, x: Array, w: Array, pool: Pool) -> Outcome:
        """Run a transient, several steps a pass over the grid."""
        work, planes = x.size * len(plan.feedback_taps), (x, pool.plane(x), pool.plane(x))
        feedback, tiling = self._compiled
        given: tuple[Any, ...]
        given = tuple(grids(plane) for plane in (*planes, w)), feedback, (*tiling, threads_for(work)), self._schedule
        if self._sleeps:
            given = *given, np.empty((len(given[0][0]) * self._count, COLUMNS))
        run = (sleeping if self._sleeps else dense).for_work(work)
        position, settled, rate, frozen = run(*given, START, self._first_slice)
        if not position[-1]:
            pace = Pace(plan, self._work)
            while not position[-1]:
                position, settled, rate, frozen = run(*given, position, pace.left)
                pace.turn(position[0], rate)
            pace.over()
        done, where = position[:2]
        end = x.copy() if where == 0 else planes[where]
        pool.keep(*(plane for plane in planes[1:] if plane is not end))
        if not self._settles:
            return Outcome(end, float(plan.duration), False, math.nan)
        return Outcome(end, done * plan.step, bool(settled), float(rate), bool(frozen))


def tile_shape(plan: Plan, threads: int, most: int) -> tuple[int, int]:
    """Return rows and columns of a tile: even parts of the grid, at least one for each thread, none too wide."""
    height, width = plan.shape
    across = -(-width // most)
    down = max(-(-height // TILE_ROWS), min(threads, -(-height // 64)))
    return -(-height // down), -(-width // across)


def widest(halo: int) -> int:
    """Return the most columns of a tile with a halo on both sides."""
    return min(TILE_COLS, (rows.STRIDE - 2 * rows.PAD) // rows.PAD * rows.PAD - 2 * halo)


def loop_kind(plan: Plan, r: int, dtype: np.dtype[Any]) -> Kernel:
    """Choose the innermost loop; float64 keeps the reference's order and rounding."""
    if dtype != np.float32 or r > 1:
        return rows.any_taps
    if "shared sums" in plan.savings:
        return rows.isotropic
    return rows.cross if all(tap.k == 0 or tap.l == 0 for tap in plan.feedback_taps) else rows.nine_taps


def square(plan: Plan, dtype: np.dtype[Any]) -> Array:
    """Return the nine middle entries of A, row by row."""
    entries = np.zeros((3, 3), dtype)
    for k, l, weight in plan.template.feedback_taps:
        if abs(k) <= 1 and abs(l) <= 1:
            entries[k + 1, l + 1] = weight
    return entries.reshape(-1)
