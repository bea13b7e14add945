"""Channels of terms on the device, with their virtual cells, and the kernels that fill and weigh them."""

from collections.abc import Sequence

import numpy as np

from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.build import boundary_defines, source
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.term_text import term_defines
from cnnsim.backends.slices import TERM
from cnnsim.backends.term_table import TermTable, characteristic
from cnnsim.planning.plan import Plan


class ChannelPlanes:
    """The channels of a table of terms, and the kernels that know its terms.

    Of all ``tables`` of a run, which share one program, it is number ``part``. ``grid`` counts each layer as a grid;
    ``gains`` of the layers and ``mask`` are for tasks that make steps.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, tables: Sequence[TermTable], part: int,
        gains: Sequence[float] = (1.0,), mask: Buffer | None = None,
    ) -> None:  # fmt: skip
        self.context, self.plan, self.grid, self.table, self.mask = context, plan, grid, tables[part], mask
        self.work = TERM * grid.cells * max(1, len(self.table.taps.k))
        self.layers = len(plan.network.layers) if plan.network else 1
        # what kernels of layers.cl end with: layers, cells of a layer, cells in all
        self.layer_arguments = np.int32(self.layers), np.int64(grid.rows * grid.cols), np.int64(grid.cells)
        r, lanes = self.table.radius, context.lanes
        self._tall, self._wide = grid.grids // self.layers * (grid.rows + 2 * r), grid.cols + 2 * r
        stride = -(-(self._wide + lanes) // lanes) * lanes
        size = self._tall * stride
        self._channels = context.buffer(max(1, len(self.table.channels)) * size * context.dtype.itemsize)
        self._weights = context.table(np.append(self.table.planes.ravel(), np.zeros(lanes, context.dtype)))
        self.gains = context.table(np.array(gains, context.dtype))
        self._last = (*map(np.int32, (r, stride, grid.rows, grid.cols)), np.int64(size))
        self._part, self._none = np.int32(part), np.int32(len(tables))
        output = characteristic(plan, context.dtype) if plan.method == "general" else None
        defines = {
            **term_defines(tables, self.layers, output, context.dtype),
            **boundary_defines(plan.boundary),
        }
        self._fill, self._add_terms = (
            context.kernel(name, "boundary", defines, source("terms")) for name in ("fill_channel", "add_terms")
        )

    def drive(self, z: Sequence[float], bias: Buffer | None, out: Buffer) -> None:
        """Write z of each layer plus the bias map plus all terms."""
        self.context.launch(
            self.context.kernel("base", "stages layers", {}), self.grid.cells,
            self.context.table(np.array(z, self.context.dtype)), bias, out, np.int32(bias is not None),
            *self.layer_arguments,
        )  # fmt: skip
        self.add_terms(TaskCode.DRIVE, out, out, out)

    def fill(self, channel: int, state: Buffer, *, output: bool = False) -> None:
        """Bring a plane's layer into a channel, perhaps through the output characteristic."""
        seen, boundary = self.table.channels[channel], self.plan.boundary
        outside = self.context.dtype.type(boundary.u if seen.quantity == "u" else boundary.y)
        work = self._tall if self.context.family == "cpu" else self._tall * self._wide  # rows, or cells
        self.context.launch(
            self._fill, self._tall * self._wide, state, self._channels,
            *map(np.int32, (channel, seen.layer, self.layers, output)), outside, *self._last, np.int64(work),
        )  # fmt: skip

    def add_terms(self, task: TaskCode, w: Buffer, x: Buffer, out: Buffer, *, at: int = 0, terms: bool = True) -> None:
        """Do a task with the drives of a state ``x``, w plus all terms; the result begins at cell ``at`` of ``out``."""
        grid, unit = self.grid, 1 if self.context.family == "cpu" else self.grid.cols  # a row, or its cells
        for first, lines in self.context.pieces(grid.lines, self.work / grid.lines):
            self.context.launch(
                self._add_terms, lines * grid.cols, x, w, self.mask, out, np.int64(at), self._channels,
                self._weights, self.gains, np.int32(task), self._part if terms else self._none,
                np.int32(self.mask is not None), np.int32(self.plan.cell == "full-range"), np.int32(self.layers),
                *self._last, np.int64(lines * unit), np.int64(first * unit),
            )  # fmt: skip
