"""What a plan looks like in arrays: made at its first transient, kept as long as the plan."""

import math
from functools import cached_property
from typing import Any

import numba
import numpy as np

from cnnsim.backends.cpu.euler.scratch import FIXED, PERIODIC, ZERO_FLUX
from cnnsim.backends.cpu.euler.tile import Rule, streaming
from cnnsim.backends.cpu.euler.window import window
from cnnsim.backends.cpu.jit.compile import Kernel
from cnnsim.backends.cpu.jit.loops import ANY, CROSS, ISOTROPIC, NINE, loop
from cnnsim.network import Boundary, Tap
from cnnsim.network.boundary import virtual_index
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array

Taps = tuple[Array, Array, Array]

BOUNDARY = {"fixed": FIXED, "zero-flux": ZERO_FLUX, "periodic": PERIODIC}
TILE_ROWS, TILE_COLS = 512, 1024
"""The most rows and columns of a tile; with `plan.MOST_HALO` on both sides a row fits a row of a buffer."""


class Prepared:
    """Taps, virtual cells and numbers of one plan, in one dtype, for one number of threads."""

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        template = plan.template
        self.control = tap_arrays(template.control_taps, dtype)
        self.around_u = around(plan.shape, template.control_taps, plan.boundary, plan.boundary.u, dtype)
        self.z = dtype.type(template.z)
        self.a = dtype.type(template.self_feedback) if plan.duration == "settled" else float(template.self_feedback)
        self.settles = plan.duration == "settled"
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        self.walls = plan.cell == "full-range"
        if plan.scheme is None:
            return
        h = plan.scheme.gain(plan.step)
        self.feedback = tap_arrays(plan.feedback_taps, dtype)
        self.around_y = around(plan.shape, plan.feedback_taps, plan.boundary, plan.boundary.y, dtype)
        self.ha = (h * plan.scheme.matrix).astype(dtype)
        self.hb = (h * np.array(plan.scheme.b)).astype(dtype)
        self.freezes = plan.step <= 1 and not self.walls
        r = max(self.around_y[2], 1)  # the loops over rows look at one neighbour at least
        self._loop, self._sleeps, self._dtype = loop_kind(plan, r, dtype), "sleep" in plan.savings, dtype
        self._numbers = (
            r, *self.feedback, square(plan, dtype), dtype.type(h), BOUNDARY[plan.boundary.kind],
            dtype.type(plan.boundary.y),
        )  # fmt: skip
        self.steps = plan.steps, plan.check_every if self.settles else 0, SETTLED_RATE, self.freezes
        self.tile = tile_shape(plan, threads)

    # Not before somebody asks, because what lies at these addresses is compiled then.

    @cached_property
    def rule(self) -> Rule:
        """Return the numbers of the feedback with the address of their loop."""
        return Rule(loop(self._loop, self._dtype).address, *self._numbers)

    @cached_property
    def tile_at(self) -> int:
        """Return the address of what does a tile: `stream`, or `step_window` where tiles sleep."""
        compiled = (window if self._sleeps else streaming)(numba.typeof(self.rule))
        return int(compiled.address)


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


def tap_arrays(taps: tuple[Tap, ...], dtype: np.dtype[Any]) -> Taps:
    """Return rows, columns and weights of taps as three arrays."""
    k, l = (np.array([tap[i] for tap in taps], dtype=np.int64) for i in (0, 1))
    return k, l, np.array([tap.weight for tap in taps], dtype=dtype)


def around(
    shape: tuple[int, int], taps: tuple[Tap, ...], boundary: Boundary, constant: float, dtype: np.dtype[Any]
) -> tuple[Array, Array, int, Any]:
    """Return which real row and column every position stands for, the radius, and the fixed virtual cells' value."""
    r = max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)
    return virtual_index(shape[0], r, boundary), virtual_index(shape[1], r, boundary), r, dtype.type(constant)
