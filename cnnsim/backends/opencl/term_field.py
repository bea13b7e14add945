"""What the terms of the general road hear, on the device: channels with their virtual cells, and their kernels."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.build import Workshop, boundary_defines, source
from cnnsim.backends.opencl.term_text import term_defines
from cnnsim.backends.term_table import TermTable, characteristic
from cnnsim.planning.plan import Plan

Buffer = cl.Buffer
DRIVE, SLOPE, STEP, DISCRETE = range(4)
"""Tasks of `Field.advance`."""


class Field:
    """The channels of a table of terms on the device with their virtual cells, and the kernels that fill and hear them.

    Of all ``tables`` of a run, which share one program, it is number ``part``.
    """

    def __init__(
        self, shop: Workshop, plan: Plan, tables: Sequence[TermTable], part: int, grids: int, layers: int,
        gains: np.ndarray[Any, Any] | None = None, held: Buffer | None = None,
    ) -> None:  # fmt: skip
        self.shop, self.plan, self.table, self.layers = shop, plan, tables[part], layers
        (rows, cols), r = plan.shape, self.table.radius
        self.size, self.lines, self.count = rows * cols, grids * layers * rows, grids * layers * rows * cols
        self.tall, self.wide = grids * (rows + 2 * r), cols + 2 * r
        stride = -(-(self.wide + shop.lanes) // shop.lanes) * shop.lanes
        channel = self.tall * stride
        self.channels = shop.buffer(max(1, len(self.table.channels)) * channel * shop.dtype.itemsize)
        self.planes = self._table(np.append(self.table.planes.ravel(), np.zeros(shop.lanes, shop.dtype)))
        self.gains = self._table(np.ones(layers, shop.dtype) if gains is None else gains)
        self.grid = (*map(np.int32, (r, stride, rows, cols)), np.int64(channel))
        self.part, self.none = np.int32(part), np.int32(len(tables))
        self.wall, self.held = np.int32(plan.cell == "full-range"), held
        shape = characteristic(plan, shop.dtype) if plan.method == "general" else None
        self.defines = {
            **term_defines(tables, layers, shape, shop.dtype),
            **boundary_defines(plan.boundary),
        }

    def _table(self, numbers: np.ndarray[Any, Any]) -> Buffer:
        return self.shop.table(np.ascontiguousarray(numbers))

    def kernel(self, name: str) -> cl.Kernel:
        """Return a kernel that knows the terms."""
        return self.shop.kernel(name, "general", self.defines, source("terms"))

    def run(self, name: str, work: int, *arguments: Any) -> int:
        """Run a kernel that knows no terms over ``work`` cells; their number is its last argument."""
        return self.shop.run(self.shop.kernel(name, "general", {}), work, *arguments, np.int64(work))

    def base(self, z: np.ndarray[Any, Any], bias: Buffer | None, out: Buffer) -> None:
        """Write z plus the bias map."""
        table = self.shop.table(z.astype(self.shop.dtype))
        self.run(
            "base", self.count, table, bias, out, np.int32(bias is not None), np.int32(self.layers), np.int64(self.size)
        )

    def follow(self, channel: int, state: Buffer, layer: int, *, through: bool = False) -> None:
        """Bring one layer of a plane into a channel, perhaps through the output characteristic."""
        quantity = self.table.channels[channel].quantity
        outside = self.plan.boundary.u if quantity == "u" else self.plan.boundary.y
        self._over_rows(
            "follow", self.tall, self.wide, state, self.channels,
            *map(np.int32, (channel, layer, self.layers, through)), self.shop.dtype.type(outside),
        )  # fmt: skip

    def advance(self, task: int, w: Buffer, x: Buffer | None, out: Buffer, *, terms: bool = True) -> Buffer:
        """Write w plus all terms; or less x, the slope; or where a step from x leads; or its output (discrete time)."""
        self._over_rows(
            "advance", self.lines, self.plan.shape[1], w if x is None else x, w, self.held, out, self.channels,
            self.planes, self.gains, np.int32(task), self.part if terms else self.none,
            np.int32(self.held is not None), self.wall, np.int32(self.layers),
        )  # fmt: skip
        return out

    def _over_rows(self, name: str, rows: int, cols: int, *arguments: Any) -> None:
        """Run a kernel whose work-items take rows on a CPU and cells on a GPU."""
        work = rows if self.shop.family == "cpu" else rows * cols
        self.shop.run(self.kernel(name), rows * cols, *arguments, *self.grid, np.int64(work))
