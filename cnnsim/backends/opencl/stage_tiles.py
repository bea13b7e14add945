"""Tiles in which all stages of a step are taken, cut and launched: a stage stays in a thread's cache."""

from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.codes import TaskCode, boundary_code
from cnnsim.backends.opencl.device.build import Defines, boundary_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.tiles import TILED_BOUNDARIES
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme

PAD = 16
"""Numbers left of a tile's rows, at least the largest radius."""
CACHE_BYTES, LITTLE_BYTES = 512 * 1024, 256 * 1024
"""What a tile works in on a CPU: half of the cache that a core has for itself; with one stage less."""
TILE_BYTES, WIDE_BYTES = 2048, 8192
"""Length of a tile's row on a CPU; with one stage longer, for which planes are read far ahead: a tenth faster."""
GPU_TILE, GPU_BYTES = (32, 64), 1 << 26
"""Rows and columns of a tile on a GPU; what all work-groups may work in, which is to stay in its cache."""
MANY = 8
"""Steps that most launches of many have at least: as much work as with so many more cells."""
WHOLE_CELLS = 1 << 14
"""Cells of a grid that is not cut where its tile may take many steps: a launch a step takes longer than they do."""


class TileShape(NamedTuple):
    """What a tile has to hold: the radius of the taps, channels and layers, and the stages of a step.

    ``many``: a tile that is a whole grid may take many steps, for which it holds state and drive as well.
    """

    radius: int
    channels: int = 1
    layers: int = 1
    scheme: Scheme | None = None
    many: bool = False

    @property
    def stages(self) -> int:
        """Stages of a step, 1 without a scheme."""
        return 1 if self.scheme is None else len(self.scheme.b)

    @property
    def keeps(self) -> bool:
        """Whether stages ask for other rates than that before them."""
        return self.scheme is not None and self.scheme.keeps_rates

    @property
    def reach(self) -> int:
        """Cells around a tile with which it is computed."""
        return self.stages * self.radius

    @property
    def areas(self) -> int:
        """Arrays of a tile's cells: its channels; states, sums and rates of each layer; its state and drive."""
        of_stages = 2 * (self.stages > 1) + self.keeps * self.stages
        return max(1, self.channels) + self.layers * (of_stages + 2 * self.many)


class StageTiles:
    """The tiles of planes (n, layers, rows, cols), and the kernels of stages.cl that do tasks in them.

    ``grid`` counts each layer as a grid; ``gain`` is in the weights of the scheme's stages. With ``many`` a launch may
    take many steps.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, shape: TileShape, gain: float, mask: Buffer | None
    ) -> None:
        self._context, self._grid = context, grid
        self.many = shape.many and _stays_whole(context, grid, shape)
        shape = shape._replace(many=self.many)
        radius, channels, layers, scheme, _ = shape
        cuts = boundary_code(plan.boundary) in TILED_BOUNDARIES and not self.many
        high, wide = _cut(context, grid, shape, cuts=cuts)
        down, across = -(-grid.rows // high), -(-grid.cols // wide)
        self.count = grid.grids // layers * down * across
        torus = plan.boundary.kind == "periodic"
        tall, width = (
            length + 2 * shape.reach if torus and parts > 1 else min(length + 2 * shape.reach, all_)
            for length, parts, all_ in ((high, down, grid.rows), (wide, across, grid.cols))
        )
        self.stride = stride = _stride(context, width, radius)
        share = PAD + shape.areas * (tall + 2 * radius) * stride + 2 * context.lanes
        bytes_ = share * context.dtype.itemsize
        most = max(1, GPU_BYTES // bytes_) if context.family == "gpu" else self.count
        cells = grid.cells * (MANY if self.many else 1)
        self._workers = context.workers(min(self.count, most), cells)
        self._scratch = context.scratch(self._workers * bytes_)
        numbers = [0.0] if scheme is None else [*scheme.matrix[1:].ravel(), *np.zeros(shape.stages), *scheme.b]
        self._table = context.table((gain * np.array(numbers)).astype(context.dtype))
        ahead = sum(round(sum(row)) << stage for stage, row in enumerate(scheme.a)) if scheme else 0
        self._how = (*map(np.int32, (shape.keeps, ahead, mask is not None, plan.cell == "full-range")),)
        self._outside = context.dtype.type(plan.boundary.u), context.dtype.type(plan.boundary.y)
        sizes = grid.rows, grid.cols, radius, stride, high, wide, down, across, tall, channels
        self._sizes = *map(np.int32, sizes), np.int64(share)
        self._mask, self._boundary = mask, boundary_defines(plan.boundary)

    def kernel(self, task: TaskCode, stem: str, defines: Defines, *, many: bool = False) -> Any:
        """Return the kernel of a task, done once or ``many`` times, with what neighbours add: kernels/<stem>.cl."""
        defines = {**defines, **self._boundary, "PAD": PAD}
        return self._context.kernel(f"do_{task.name.lower()}{'s' * many}", f"boundary {stem} tile stages", defines)

    def do(
        self, kernel: Any, planes: tuple[Buffer, Buffer | None, Buffer], before: Buffer | None,
        of_layers: tuple[Buffer, Buffer], rest: tuple[Any, ...], work: float, *, rounds: int = 1, bare: bool = False,
        measured: bool = False,
    ) -> tuple[float, bool]:  # fmt: skip
        """Do a kernel's task with (x, w, out), some ``rounds`` where tiles do ``many``; ``bare``: without neighbours.

        Return the largest rate or change, and whether out differs. The change is that from x; what ``out`` differs from
        are the outputs ``before``.
        """
        context, (x, w, out), largest, differs = self._context, planes, 0.0, False
        for first, count in context.pieces(self.count, rounds * work / self.count):
            context.launch_workers(
                kernel, min(self._workers, count), x, w, self._mask, out, before, self._scratch, context.partial,
                self._table, *of_layers, np.int32(bare), np.int32(rounds), *self._how, *self._outside, *self._sizes,
                np.int64(first), np.int64(count), *rest,
            )  # fmt: skip
            if measured:
                parts = context.parts(2 * min(self._workers, count), context.dtype).reshape(-1, 2).max(axis=0)
                largest, differs = max(largest, float(parts[0])), differs or bool(parts[1])
        return largest, differs


def _stride(context: DeviceContext, width: int, radius: int) -> int:
    """Return how far apart rows lie: not a power of two, of which all would share cache sets."""
    lanes = context.lanes
    return -(-(width + 2 * radius) // lanes) * lanes + PAD


def _stays_whole(context: DeviceContext, grid: DeviceGrid, shape: TileShape) -> bool:
    """Return whether a tile is to be all of a grid: where many of them fit a cache, and no core is left without."""
    numbers = shape.areas * (grid.rows + 2 * shape.radius) * _stride(context, grid.cols, shape.radius)
    busy = grid.grids // shape.layers >= 2 * context.cores or shape.layers * grid.rows * grid.cols <= WHOLE_CELLS
    return numbers * context.dtype.itemsize <= CACHE_BYTES and busy


def _cut(context: DeviceContext, grid: DeviceGrid, shape: TileShape, *, cuts: bool) -> tuple[int, int]:
    """Return the rows and columns of a tile; without ``cuts`` it is all of a grid, which then knows any boundary."""
    rows, cols, reach, lanes = grid.rows, grid.cols, shape.reach, context.lanes
    if not cuts:
        return rows, cols
    if context.family == "gpu":
        high, wide = (max(length, 4 * reach) for length in GPU_TILE)
        return min(rows, high), min(cols, wide)
    size, grids = context.dtype.itemsize, grid.grids // shape.layers
    tile_bytes, row_bytes = (LITTLE_BYTES, WIDE_BYTES) if shape.stages == 1 else (CACHE_BYTES, TILE_BYTES)
    across = -(-cols // max(row_bytes // size, 8 * reach))
    wide = cols if across == 1 else -(-cols // (across * lanes)) * lanes
    line = shape.areas * size * _stride(context, min(cols, wide + 2 * reach), shape.radius)
    high = max(tile_bytes // line - 2 * reach, 4 * reach, 8)
    down = max(-(-rows // high), min(-(-2 * context.cores // (grids * across)), rows // max(12 * reach, 16)))
    return -(-rows // max(1, down)), wide
