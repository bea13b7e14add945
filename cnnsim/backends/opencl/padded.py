"""Padded planes on the device: rows with room for virtual cells and whole vectors, for networks (kernels/ghosts.cl)."""

from typing import Any

import numpy as np

from cnnsim.backends.opencl.device.build import boundary_defines
from cnnsim.backends.opencl.device.context import GROUP, Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.network import Boundary

PAD = 16
"""Numbers before the first column of a row, at least the largest radius."""
WHOLE_CELLS, CACHE_BYTES = 1 << 14, 1 << 19
"""Cells of a grid, and bytes of a plane of it, up to which one work-item takes a whole grid through many steps."""
GPU_CELLS = 4
"""Cells that a work-item takes in a launch of one turn on a GPU."""


class PaddedPlanes:
    """The layout of padded planes (n, layers, rows, cols), and their transfer; ``grid`` counts each layer as a grid.

    ``whole``: a unit of work is a grid with all its layers, so a launch can take many steps; otherwise a few rows.
    """

    def __init__(self, context: DeviceContext, grid: DeviceGrid, layers: int, radius: int, boundary: Boundary) -> None:
        self._context, self._grid = context, grid
        self.radius = radius
        self.stride = -(-grid.cols // context.lanes) * context.lanes + PAD
        tall = grid.rows + 2 * radius
        self.size = grid.grids * tall * self.stride + PAD + context.lanes
        self._boundary = {**boundary_defines(boundary), "PAD": PAD}
        grids = grid.grids // layers
        small = layers * grid.rows * grid.cols <= WHOLE_CELLS
        fits = layers * tall * self.stride * context.dtype.itemsize <= CACHE_BYTES
        self.whole = small or (fits and grids >= 2 * context.cores)
        height = layers * grid.rows if self.whole else 1
        if not self.whole and context.family == "gpu":
            height = max(1, min(grid.rows, GPU_CELLS * GROUP // grid.cols))
        self.height, self.units, self.cells = height, -(-grid.lines // height), grid.cells

    def new(self, count: int) -> Buffer:
        """Return a buffer of ``count`` planes of zeros; the gaps between rows are read, so they must be finite."""
        size = count * self.size * self._context.dtype.itemsize
        buffer = self._context.buffer(size)
        self._context.clear(buffer, size // 8 * 8)
        return buffer

    def pad(self, plane: Buffer, to: Buffer, number: int, outside: float) -> None:
        """Write a plane to plane ``number`` of a buffer; fixed virtual cells hold ``outside``."""
        self._transfer("pad", plane, to, number, self._context.dtype.type(outside))

    def unpad(self, planes: Buffer, number: int, to: Buffer) -> None:
        """Write plane ``number`` of a buffer to a plane."""
        self._transfer("unpad", planes, to, number)

    def _transfer(self, name: str, from_: Buffer, to: Buffer, number: int, *outside: Any) -> None:
        grid = self._grid
        sizes = self.radius, self.stride, grid.rows, grid.cols, grid.lines
        kernel = self._context.kernel(name, "boundary ghosts padded", self._boundary)
        self._context.launch(
            kernel, grid.cells, from_, to, np.int64(number * self.size), *outside, *map(np.int32, sizes)
        )

    @property
    def defines(self) -> dict[str, str | int]:
        """The definitions that ghosts.cl needs."""
        return dict(self._boundary)

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The sizes that kernels of network.cl take."""
        grid = self._grid
        sizes = np.array([grid.rows, grid.cols, grid.lines, self.stride], np.int32)
        return *sizes, np.int64(self.size), np.int32(self.height)
