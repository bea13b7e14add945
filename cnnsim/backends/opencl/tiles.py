"""Tiles of a grid that fit a core's cache, for steps of a one-stage scheme on a CPU."""

from typing import Any, NamedTuple

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.device.build import Defines
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.slices import PIECE
from cnnsim.network import reach
from cnnsim.planning.plan import Plan

ROWS = 4
"""Rows that a level of a tile steps at a time on a CPU, R in block.cl."""
ROW_BYTES, SMALL_ROW_BYTES = 2048, 512
"""Length of a tile's row on a CPU, and of a tile that may sleep."""
SMALL_ROWS = 32
"""Rows of a tile that may sleep."""
SCRATCH = 1 << 19
"""The most bytes of a tile's rows on a CPU: half of a second-level cache of 1 MiB."""
QUICK = 4
"""Sums that the steps of tiles do in the time of one elsewhere, since they read from the cache."""

_STEPS = 24, 24, 8, 4, 2
"""The most steps a launch for radius 0, 1, 2, 3 and more."""


class Tiles(NamedTuple):
    """How to launch: the ``number`` of tiles, a work-group each, the ``steps`` of a launch, and the kernel's arguments.

    ``around``: how many tiles (down, across) on each side hold the cells that a launch reads.
    """

    number: int
    steps: int
    defines: Defines
    arguments: tuple[Any, ...]
    local_size: tuple[int, int]
    around: tuple[Any, Any] = (np.int32(1), np.int32(1))
    quick: int = QUICK

    def global_size(self, count: int) -> tuple[int, int]:
        """Return the global size for ``count`` tiles."""
        return count * self.local_size[0], self.local_size[1]


def cut(context: DeviceContext, grid: DeviceGrid, plan: Plan, *, small: bool = False) -> Tiles:
    """Cut grids into tiles, and steps into launches of about equal length; ``small`` tiles can sleep, on a CPU."""
    radius, steps = reach((tap.k, tap.l) for tap in plan.feedback_taps), 1
    if "blocking" in plan.savings:
        steps = min(plan.steps, plan.check_every) if plan.duration == "settled" else plan.steps
    most = _STEPS[min(radius, 4)]
    launches = -(-steps // most)
    if 0 < launches <= 4:  # only longer runs need wider halos; from there on they share a kernel
        most = -(-steps // launches)
    tiles = _bands(context, grid, plan, radius, most, small)
    launches = -(-steps // tiles.steps)
    return tiles._replace(steps=-(-steps // launches)) if launches else tiles


def _bands(
    context: DeviceContext, grid: DeviceGrid, plan: Plan, radius: int, most: int, small: bool, widest: int = 0
) -> Tiles:
    (grids, rows, cols), lanes, size = grid, context.lanes, context.dtype.itemsize
    widest = widest or (SMALL_ROW_BYTES if small else ROW_BYTES) // size
    across = -(-cols // widest)
    if across == 1:  # the tile has all columns: only virtual cells lie to its left and right
        halo, shift, length = 0, lanes, lanes
        while length < cols:
            length *= 2  # few sizes, so that few kernels are built
        stride = length + 2 * lanes
    else:
        halo = shift = -(-(_whole((most - 1) * radius, 1, lanes) + radius) // lanes) * lanes
        stride = widest + 2 * halo
    stride += 16  # rows that lie apart by a power of two would share cache sets
    width = cols if across == 1 else _whole(cols, across, lanes)
    across = -(-cols // width)
    down = -(-8 * context.cores // (grids * across))  # enough tiles that no core waits long for the last one
    down = max(down, -(-rows * width * most * len(plan.feedback_taps) // PIECE))  # short enough for an interrupt
    down = min(down, rows // (8 * most * max(1, radius)), rows * width // 16384)
    if small:  # a band has at least the rows that one launch reads of the next
        down = max(down, rows // max(SMALL_ROWS, most * radius))
    down = max(1, down)
    band = _whole(rows, down, ROWS)
    down = -(-rows // band)
    room = min(SCRATCH, context.device.local_mem_size) // (stride * size) - 5 * most * radius
    slide = min(room // 4, band + 2 * most * radius)  # rows that come in before the live ones are moved up
    if slide < ROWS:  # no room: fewer steps a launch, but rather narrower tiles than fewer than four
        narrower = most <= 4 and widest > 2 * lanes
        most, widest = (most, widest // 2) if narrower else (most - 1, widest)
        return _bands(context, grid, plan, radius, most, small, widest)
    live = most * radius + slide
    defines: dict[str, str | int] = {"T": most, "HALO": halo, "SHIFT": shift, "STRIDE": stride}
    torus = plan.boundary.kind == "periodic"
    if torus and across > 1:
        defines["COPIES"] = ""
    scratch = cl.LocalMemory((most * radius + 4 * live) * stride * size)
    numbers = np.array([live, rows, cols, width, band, across, down], np.int32)
    # round a torus past a short last tile
    around = [1 + (torus and rows - (down - 1) * band < most * radius), 1]
    around[1] += torus and cols - (across - 1) * width < most * radius
    return Tiles(
        grids * across * down, most, defines, (scratch, *numbers), (1, 1), (np.int32(around[0]), np.int32(around[1]))
    )


def _whole(length: int, parts: int, unit: int) -> int:
    """Return the length of each of ``parts`` parts, a multiple of the unit."""
    return -(-length // (parts * unit)) * unit
