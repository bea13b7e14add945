"""How a grid is cut into tiles that fit a core's cache or a GPU's local memory, for steps of a one-stage scheme."""

from typing import Any, NamedTuple

import numpy as np
import pyopencl as cl

from cnnsim.backends.codes import BoundaryCode
from cnnsim.backends.opencl.device.build import Defines
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.opencl.device.devices import family_of
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.slices import PIECE
from cnnsim.network import reach
from cnnsim.planning.plan import Plan

TILED_BOUNDARIES = BoundaryCode.FIXED, BoundaryCode.ZERO_FLUX, BoundaryCode.PERIODIC
"""Boundaries that the kernels of tiles (cpu.cl, gpu.cl, sleep.cl) know; with any other, steps go by stages."""
TILE_BYTES = 2048
"""Length of a tile's row on a CPU. Measured: with 1 KiB and with 4 KiB the transient is 6 to 18 % slower."""
ROWS = 4
"""Rows that a level of a tile steps at a time on a CPU, as in block.cl: with the outputs around them, their states and
drives they fit a first-level cache of 48 KiB. Measured: with 3 and with 5 no faster."""
SCRATCH = 1 << 19
"""The most bytes of a tile's rows on a CPU: half of a second-level cache of 1 MiB."""
FEW_CELLS = 1 << 12
"""Cells of a grid up to which a row is stepped at a time. Measured: a template's first run takes 0.3 s of 2 less, every
other one as long, or up to half as long again for 64 x 64 cells (of 3 ms for 2000 steps)."""
SLEEPER = 64, 512
"""Rows, and bytes of a row, of a tile that may sleep on a CPU: small, so that many can."""
LIGHT_SLEEPER = 16, 256
"""The same where most of them sleep."""
STACK = 8
"""Light sleepers below each other that a work-item does: rows around those awake are computed again once for all."""
NAP = 10
"""Cells around a light sleeper that wake it, at most. Measured on a picture of 1024 x 1024 with holes: with 5, where
less area is computed in twice as many launches, it takes a fifth longer."""
LOCAL_BYTES = 48 * 1024
"""Local memory of a work-group on a GPU: what every one has without asking for more."""

_STEPS = {"cpu": (24, 24, 8, 4, 2), "gpu": (4, 4, 2, 1, 1)}
"""The most steps a launch for radius 0, 1, 2, 3 and more."""


class Tiles(NamedTuple):
    """How to launch: sizes, the steps of a launch, and what the kernels need to know, built in or as arguments.

    A work-group does one tile, or a stack of some; ``number`` is that of the tiles.
    """

    number: int
    steps: int
    defines: Defines
    arguments: tuple[Any, ...]
    groups: int
    global_size: tuple[int, int]
    local_size: tuple[int, int]


def cut(context: DeviceContext, grid: DeviceGrid, plan: Plan, *, light: bool = False) -> Tiles:
    """Cut grids into tiles; steps that come at a stretch go in launches of about equal length.

    With the saving "sleep", tiles in which no output can change are to be left out, so they should be small; on a CPU
    they are smaller still, and cost more, where sleep is ``light``.
    """
    radius, steps, sleep = reach((tap.k, tap.l) for tap in plan.feedback_taps), 1, "sleep" in plan.savings
    if "blocking" in plan.savings:
        steps = min(plan.steps, plan.check_every) if plan.duration == "settled" else plan.steps
    most = _STEPS[context.family][min(radius, 4)]
    if light:
        most = min(most, max(1, NAP // max(1, radius)))
    launches = -(-steps // most)
    if 0 < launches <= 4:  # no rows and columns that only longer launches need; later on no kernel of its own
        most = -(-steps // launches)
    if context.family == "cpu":
        row_bytes = LIGHT_SLEEPER[1] if light else SLEEPER[1] if sleep else TILE_BYTES
        lowest = (LIGHT_SLEEPER if light else SLEEPER)[0] if sleep else None
        tiles = _bands(context, grid, plan, radius, most, row_bytes // context.dtype.itemsize, lowest)
    else:
        tiles = _squares(context, grid, radius, most)
    launches = -(-steps // tiles.steps)
    return tiles._replace(steps=-(-steps // launches)) if launches else tiles


def _bands(
    context: DeviceContext, grid: DeviceGrid, plan: Plan, radius: int, most: int, widest: int, lowest: int | None
) -> Tiles:
    grids, rows, cols = grid
    lanes, size = context.lanes, context.dtype.itemsize
    height = ROWS if rows * cols > FEW_CELLS else 1
    across = -(-cols // widest)
    if across == 1:  # the tile has all columns: nothing but virtual cells beside it
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
    down = -(-8 * context.cores // (grids * across))  # so many tiles that no core waits long for the last one
    down = max(down, -(-rows * width * most * len(plan.feedback_taps) // PIECE))  # soon done: a stop is heard
    down = min(down, rows // (8 * most * max(1, radius)), rows * width // 16384)
    if lowest is not None:  # a band has at least the rows that one launch reads of the next
        down = max(down, rows // max(lowest, most * radius))
    down = max(1, down)
    band = _whole(rows, down, height)
    down = -(-rows // band)
    stack = STACK if lowest == LIGHT_SLEEPER[0] else 1
    room = min(SCRATCH, context.device.local_mem_size) // (stride * size) - 5 * most * radius
    slide = min(room // 4, stack * band + 2 * most * radius)  # rows that come in before the live ones are moved up
    live = most * radius + slide
    defines: dict[str, str | int] = {"R": height, "T": most, "HALO": halo, "SHIFT": shift, "STRIDE": stride}
    defines["STACK"] = stack
    if plan.boundary.kind == "periodic" and across > 1:
        defines["COPIES"] = ""
    if slide < height:  # no room: fewer steps a launch, but rather narrower tiles than fewer than four
        narrower = most <= 4 and widest > 2 * lanes
        most, widest = (most, widest // 2) if narrower else (most - 1, widest)
        return _bands(context, grid, plan, radius, most, widest, lowest)
    scratch = cl.LocalMemory((most * radius + 4 * live) * stride * size)
    numbers = np.array([live, rows, cols, width, band, across, down], np.int32)
    groups = grids * across * -(-down // stack)
    return Tiles(grids * across * down, most, defines, (scratch, *numbers), groups, (groups, 1), (1, 1))


def _whole(length: int, parts: int, unit: int) -> int:
    """Return the length of each of so many parts, a multiple of the unit."""
    return -(-length // (parts * unit)) * unit


def _squares(context: DeviceContext, grid: DeviceGrid, radius: int, most: int) -> Tiles:
    grids, rows, cols = grid
    halo = most * radius
    limit = min(LOCAL_BYTES, context.device.local_mem_size)
    best: tuple[float, int, int] = (0.0, 0, 0)
    on_gpu = family_of(context.device) == "gpu"
    for wide, high in ((64, 64), (64, 32), (32, 32)) if on_gpu else ((32, 16),):  # elsewhere to be tested: small
        bytes_ = 2 * (wide + 2 * radius) * (high + 2 * radius) * context.dtype.itemsize
        useful = (wide - 2 * halo) * (high - 2 * halo) / (wide * high) if high > 2 * halo else 0.0
        if bytes_ <= limit and useful > best[0]:
            best = useful, wide, high
    _, wide, high = best
    items = min(512 if radius > 2 else 256 if on_gpu else 128, context.device.max_work_group_size, high * wide)
    column = high * wide // items  # cells of a work-item
    across, down = -(-cols // (wide - 2 * halo)), -(-rows // (high - 2 * halo))
    defines: dict[str, str | int] = {"R": column, "T": most, "HALO": halo, "WIDE": wide, "HIGH": high}
    numbers = np.array([rows, cols, across, down], np.int32)
    local = wide, high // column
    count = grids * across * down
    return Tiles(count, most, defines, tuple(numbers), count, (count * wide, local[1]), local)
