"""Tiles in which the terms of a table are added up on the device, with their channels."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.channel_text import ChannelSource, ChannelText, channel_defines
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.stage_tiles import StageTiles, TileShape
from cnnsim.backends.opencl.term_text import term_defines
from cnnsim.backends.slices import TERM
from cnnsim.backends.term_table import TermTable, characteristic
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme

_KERNELS = {
    "none": "PLAIN(do_drive, TASK_DRIVE, 0)",
    "discrete-time": "PLAIN(do_drive, TASK_DRIVE, 0) MEASURED(do_discrete, TASK_DISCRETE) "
    "PLAIN(do_discretes, TASK_DISCRETE, 1)",
    "other": "PLAIN(do_drive, TASK_DRIVE, 0) PLAIN(do_step, TASK_STEP, 0) PLAIN(do_steps, TASK_STEP, 1) "
    "MEASURED(do_check, TASK_CHECK)",
}
"""The tasks of a program: without a time loop, in discrete time and by a scheme."""


class TermTiles:
    """The tiles of a network's planes, and the kernel that knows the terms of all ``tables`` of a run.

    ``grid`` counts each layer as a grid; ``gains`` of the layers and ``mask`` are for tasks that make steps.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, tables: Sequence[TermTable],
        gains: Sequence[float] = (1.0,), mask: Buffer | None = None,
    ) -> None:  # fmt: skip
        self._context, self._plan, self._grid, self._tables, self._mask = context, plan, grid, tables, mask
        layers = len(plan.network.layers) if plan.network else 1
        general = plan.method == "general"
        self._scheme = plan.scheme if general else None
        self._gains = context.table(np.array(gains, context.dtype))
        ahead = [round(sum(row)) for row in self._scheme.a] if self._scheme else [0]
        outputs = plan.cell != "discrete-time"
        self._channels = [ChannelText(table, outputs=outputs) for table in tables]
        fills, self._sources = channel_defines(self._channels, ahead, outputs=outputs)
        output = characteristic(plan, context.dtype) if general else None
        self._defines = {
            **term_defines(tables, self._channels, layers, output, context.dtype),
            **fills,
            "KERNELS": _KERNELS["none" if output is None else "other" if self._scheme else "discrete-time"],
        }
        self._layers, none = layers, np.zeros(context.lanes, context.dtype)
        self._weights = [context.table(np.append(table.planes.ravel(), none)) for table in tables]
        self.work = [TERM * grid.cells * max(1, len(table.taps.k)) for table in tables]

    @cached_property
    def _of_inputs(self) -> StageTiles:
        return self._tiles(0)

    @cached_property
    def _of_checks(self) -> StageTiles:
        return self._tiles(1)

    @cached_property
    def _of_steps(self) -> StageTiles:
        return self._tiles(1, self._scheme, many=not any(source.ago and not source.input for source in self._sources))

    @property
    def many(self) -> bool:
        """Whether many steps may be taken at once: grids are small, and no term looks back."""
        return self._of_steps.many

    def _tiles(self, part: int, scheme: Scheme | None = None, *, many: bool = False) -> StageTiles:
        copied = len(self._channels[part].copied)
        shape = TileShape(self._tables[part].radius, copied, self._layers, scheme, many)
        return StageTiles(self._context, self._plan, self._grid, shape, 1.0, self._mask)

    def drive(
        self, z: Sequence[float], bias: Buffer | None, out: Buffer, planes: Callable[[ChannelSource], Any]
    ) -> None:
        """Write z of each layer plus the bias map plus all terms of the input.

        ``planes`` gives the plane that a channel is filled from, None where it is not the input.
        """
        rest = *(planes(source) or out for source in self._sources), self._weights[0]
        of_layers = self._gains, self._context.table(np.array(z, self._context.dtype))
        kernel = self._of_inputs.kernel(TaskCode.DRIVE, self._plan, "terms", self._defines)
        self._of_inputs.do(kernel, (out, bias, out), None, of_layers, rest, self.work[0])

    def do(
        self, task: TaskCode, planes: tuple[Buffer, Buffer, Buffer], sources: Callable[[ChannelSource], Buffer], *,
        before: Buffer | None = None, over: Sequence[float] = (), rounds: int = 1, **how: Any,
    ) -> tuple[float, bool]:  # fmt: skip
        """Do a task of stages.cl with (x, w, out) and all terms that are not of the input alone; see `StageTiles.do`.

        Return the largest rate or change, and whether the outputs differ from those ``before`` the last step.
        """
        tiles = self._of_checks if task == TaskCode.CHECK else self._of_steps
        rest = *map(sources, self._sources), self._weights[1]
        of_layers = self._gains, self._context.table(np.array(over or [1.0], self._context.dtype))
        kernel = tiles.kernel(task, self._plan, "terms", self._defines, many=rounds > 1)
        return tiles.do(kernel, planes, before, of_layers, rest, self.work[1], rounds=rounds, **how)
