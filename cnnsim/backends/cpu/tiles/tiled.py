"""Steps by tiles, prepared: the numbers of the feedback, the tiles, and what is compiled for both."""

from functools import cached_property
from typing import Any

import numba
import numpy as np

from cnnsim.backends.codes import boundary_code
from cnnsim.backends.cpu.jit.columns import tap_records
from cnnsim.backends.cpu.jit.compile import Kernel
from cnnsim.backends.cpu.tiles.grid import Edge, Feedback
from cnnsim.backends.cpu.tiles.loops import ANY, CROSS, ISOTROPIC, NINE, loop
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.backends.cpu.tiles.scratch import GROUP
from cnnsim.backends.cpu.tiles.sleep import WIDTH
from cnnsim.backends.cpu.tiles.stage_rows import stage_loop
from cnnsim.backends.cpu.tiles.tile import streaming
from cnnsim.backends.cpu.tiles.window import HEIGHT, window
from cnnsim.backends.slices import Pace
from cnnsim.network import reach
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme
from cnnsim.support import Array

TILE_ROWS, TILE_COLS = 512, 1024
"""The most rows and columns of a tile; with `plan.MOST_HALO` on both sides a row fits a row of a buffer."""


class Tiled:
    """Steps of one plan by tiles, in one dtype, for one number of threads; with a mask, or without.

    Euler steps without mask and limit are fused, and tiles may sleep in them; all others go stage by stage.
    """

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int, *, masked: bool) -> None:
        scheme, boundary = plan.scheme, plan.boundary
        assert scheme is not None
        limited, count = plan.cell == "full-range", len(scheme.b)
        self._fused = count == 1 and not limited and not masked
        self.sleeps = self._fused and "sleep" in plan.savings
        r = max(reach((tap.k, tap.l) for tap in plan.feedback_taps), 1)  # the loops over rows take a radius of 1
        self._loop, self._dtype, h = loop_kind(plan, r, dtype), dtype, scheme.gain(plan.step)
        stages = 0 if self._fused else count
        lives = 2 + masked + (0 if count == 1 else 2 + (count - 1) * scheme.keeps_rates)
        self._numbers = (
            tap_records(plan.feedback_taps, dtype), square(plan, dtype) if self._fused else table_of(scheme, h, dtype),
            dtype.type(h), *Edge(r, int(boundary_code(boundary)), dtype.type(boundary.y)), stages, lives, limited,
        )  # fmt: skip
        depth, rows = plan.depth, plan.shape[0]
        if stages and rows <= GROUP // 2:  # a grid so low goes through the levels as one group, if they are few
            depth = max(1, min(depth, (GROUP - rows) // (stages * r)))
        shape = tile_shape(plan, threads, widest(depth * max(1, stages) * r))
        self._tile = depth, *shape
        rows, cols = (HEIGHT, WIDTH) if self.sleeps else shape
        self.count = -(-plan.shape[0] // rows) * -(-plan.shape[1] // cols)
        self.work = rows * cols * max(1, len(plan.feedback_taps)) * max(1, stages)
        self.first_slice = Pace(plan, self.work).left

    # Not before somebody asks, because what lies at these addresses is compiled then.

    @cached_property
    def feedback(self) -> Any:
        """Return the numbers of the feedback with the address of their loop."""
        compiled = loop(self._loop, self._dtype) if self._fused else stage_loop(self._dtype)
        return tuple(Feedback(compiled.address, *self._numbers))

    @cached_property
    def tiles(self) -> tuple[int, ...]:
        """Return `Tiling` less the threads; at their address is `stream`, or `step_window` where tiles sleep."""
        compiled = (window if self.sleeps else streaming)(numba.typeof(self.feedback))
        return int(compiled.address), *self._tile


def tile_shape(plan: Plan, threads: int, most: int) -> tuple[int, int]:
    """Return rows and columns of a tile: even parts of the grid, at least one for each thread, none too wide."""
    rows, cols = plan.shape
    across = -(-cols // most)
    down = max(-(-rows // TILE_ROWS), min(threads, -(-rows // 64)))
    return -(-rows // down), -(-cols // across)


def widest(halo: int) -> int:
    """Return the most columns of a tile with so many around it."""
    return min(TILE_COLS, (STRIDE - 2 * PAD) // PAD * PAD - 2 * halo)


def loop_kind(plan: Plan, r: int, dtype: np.dtype[Any]) -> Kernel:
    """Choose the innermost loop (see `tiles.rows`); float64 keeps the reference's order and rounding."""
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


def table_of(scheme: Scheme, h: float, dtype: np.dtype[Any]) -> Array:
    """Return a scheme's table times h: the rows of a as a square, then b."""
    return np.concatenate(((h * scheme.matrix).reshape(-1), h * np.array(scheme.b))).astype(dtype)
