"""Plan constants converted to NumPy arrays for the loops: made at the first transient, kept as long as the plan."""

import math
from functools import cached_property
from typing import Any

import numba
import numpy as np

from cnnsim.backends.codes import boundary_code
from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.euler.boundary import KNOWN
from cnnsim.backends.cpu.euler.grid import Edge, Feedback, Schedule
from cnnsim.backends.cpu.euler.loops import ANY, CROSS, ISOTROPIC, NINE, loop
from cnnsim.backends.cpu.euler.sleep import HEIGHT, WIDTH
from cnnsim.backends.cpu.euler.tile import streaming
from cnnsim.backends.cpu.euler.window import window
from cnnsim.backends.cpu.jit.columns import tap_records
from cnnsim.backends.cpu.jit.compile import Kernel
from cnnsim.backends.slices import Pace
from cnnsim.network import reach
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array

TILE_ROWS, TILE_COLS = 512, 1024
"""The most rows and columns of a tile; with `plan.MOST_HALO` on both sides a row fits a row of a buffer."""


class Prepared:
    """Taps, virtual cells and numbers of one plan, in one dtype, for one number of threads.

    Groups of parameters are bare tuples, in the order of the NamedTuple that names them: numba asks for the class of
    every NamedTuple that it is given, which takes 1.2 us.
    """

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        template, boundary = plan.template, plan.boundary
        self.control = tap_records(template.control_taps, dtype)
        r = reach((tap.k, tap.l) for tap in template.control_taps)
        self.around_u = virtual_cells(plan.shape, r, boundary, dtype.type(boundary.u))
        self.z = dtype.type(template.z)
        self.settles, self.limited = plan.duration == "settled", plan.cell == "full-range"
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        a = dtype.type(template.self_feedback) if self.settles else float(template.self_feedback)
        self.cell = a, self.t, self.limited
        if plan.scheme is None:
            return
        h = plan.scheme.gain(plan.step)
        self.feedback_taps = tap_records(plan.feedback_taps, dtype)
        r = reach((tap.k, tap.l) for tap in plan.feedback_taps)
        constant = dtype.type(boundary.y)
        self.around_y = virtual_cells(plan.shape, r, boundary, constant)
        self.scheme = (
            (h * plan.scheme.matrix).astype(dtype), (h * np.array(plan.scheme.b)).astype(dtype), self.limited
        )  # fmt: skip
        self.fused_euler = len(plan.scheme.b) == 1 and not self.limited and boundary_code(boundary) in KNOWN
        if not self.fused_euler:
            return
        r, taps = max(r, 1), len(plan.feedback_taps)  # the loops over rows take a radius of 1 at least
        self._loop, self._sleeps, self._dtype = loop_kind(plan, r, dtype), "sleep" in plan.savings, dtype
        self._numbers = (
            self.feedback_taps, square(plan, dtype), dtype.type(h), *Edge(r, int(boundary_code(boundary)), constant)
        )  # fmt: skip
        check_every = plan.check_every if self.settles else 0
        self.schedule = tuple(Schedule(plan.steps, check_every, SETTLED_RATE, plan.saturation_ends))
        self._tile = plan.depth, *tile_shape(plan, threads)
        rows, cols = (HEIGHT, WIDTH) if self._sleeps else self._tile[1:]
        self.tile_count, self.tile_work = (
            -(-plan.shape[0] // rows) * -(-plan.shape[1] // cols),
            rows * cols * max(1, taps),
        )
        self.first_slice = Pace(plan, self.tile_work).left

    # Not before somebody asks, because what lies at these addresses is compiled then.

    @cached_property
    def feedback(self) -> Any:
        """Return the numbers of the feedback with the address of their loop."""
        return tuple(Feedback(loop(self._loop, self._dtype).address, *self._numbers))

    @cached_property
    def tiles(self) -> tuple[int, ...]:
        """Return `Tiling` less the threads; at their address is `stream`, or `step_window` where tiles sleep."""
        compiled = (window if self._sleeps else streaming)(numba.typeof(self.feedback))
        return int(compiled.address), *self._tile


def tile_shape(plan: Plan, threads: int) -> tuple[int, int]:
    """Return rows and columns of a tile: even parts of the grid, at least one for each thread, none too wide."""
    rows, cols = plan.shape
    across = -(-cols // TILE_COLS)
    down = max(-(-rows // TILE_ROWS), min(threads, -(-rows // 64)))
    return -(-rows // down), -(-cols // across)


def loop_kind(plan: Plan, r: int, dtype: np.dtype[Any]) -> Kernel:
    """Choose the innermost loop (see `euler.rows`); float64 keeps the reference's order and rounding."""
    if dtype != np.float32 or r > 1:
        return ANY
    if "shared sums" in plan.savings:
        return ISOTROPIC
    return CROSS if all(tap.k == 0 or tap.l == 0 for tap in plan.feedback_taps) else NINE


def square(plan: Plan, dtype: np.dtype[Any]) -> Array:
    """Return the nine middle entries of A, row by row."""
    entries = np.zeros((3, 3), dtype)
    for k, l, weight in plan.template.feedback_taps:
        if abs(k) <= 1 and abs(l) <= 1:
            entries[k + 1, l + 1] = weight
    return entries.reshape(-1)
