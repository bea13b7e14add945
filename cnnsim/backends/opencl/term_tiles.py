"""Tiles in which the terms of a table are added up on the device, with their channels."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.channel_text import ChannelSource, ChannelText, channel_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.stage_tiles import StageTiles, TileShape
from cnnsim.backends.opencl.term_text import term_defines
from cnnsim.backends.slices import TERM
from cnnsim.backends.term_table import TermTable, characteristic
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme

_DRIVE = "PLAIN(do_drive, TASK_DRIVE, 0)"
_DISCRETE = "MEASURED(do_discrete, TASK_DISCRETE) PLAIN(do_discretes, TASK_DISCRETE, 1)"
_STEPS = "PLAIN(do_step, TASK_STEP, 0) PLAIN(do_steps, TASK_STEP, 1) MEASURED(do_check, TASK_CHECK)"


class TermTiles:
    """The tiles of a network's planes, and the kernels that know the terms of a table.

    ``grid`` counts each layer as a grid; ``gains`` of the layers and ``mask`` are for tasks that make steps, without
    which it is the drive of the input alone that is asked for: then networks with the same drive share its kernel.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, table: TermTable,
        gains: Sequence[float] = (), mask: Buffer | None = None,
    ) -> None:  # fmt: skip
        self._context, self._plan, self._grid, self._table, self._mask = context, plan, grid, table, mask
        self._layers = layers = len(plan.network.layers) if plan.network else 1
        self._scheme = plan.scheme if gains else None
        self._gains = context.table(np.array(gains or [1.0] * layers, context.dtype))
        ahead = [round(sum(row)) for row in self._scheme.a] if self._scheme else [0]
        outputs = plan.cell != "discrete-time"
        self._channels = ChannelText(table, outputs=outputs)
        fills, self._sources = channel_defines(self._channels, ahead, outputs=outputs)
        self._defines = {
            **term_defines(
                table, self._channels, layers, characteristic(plan, context.dtype) if gains else None, context.dtype
            ),
            **fills,
            "KERNELS": _STEPS if self._scheme else _DISCRETE if gains else _DRIVE,
            "STAGES": len(ahead),
        }
        self._weights = context.table(np.append(table.planes.ravel(), np.zeros(context.lanes, context.dtype)))
        self.work = TERM * grid.cells * max(1, len(table.taps.k))

    @cached_property
    def _at_once(self) -> StageTiles:
        return self._tiles()

    @cached_property
    def _of_steps(self) -> StageTiles:
        return self._tiles(self._scheme, many=not any(source.ago and not source.input for source in self._sources))

    @property
    def many(self) -> bool:
        """Whether many steps may be taken at once: grids are small, and no term looks back."""
        return self._of_steps.many

    def _tiles(self, scheme: Scheme | None = None, *, many: bool = False) -> StageTiles:
        shape = TileShape(self._table.radius, len(self._channels.copied), self._layers, scheme, many)
        return StageTiles(self._context, self._plan, self._grid, shape, 1.0, self._mask)

    def drive(
        self, z: Sequence[float], bias: Buffer | None, out: Buffer, planes: Callable[[ChannelSource], Buffer]
    ) -> None:
        """Write z of each layer plus the bias map plus all terms; ``planes``: that which a channel is filled from."""
        rest = *map(planes, self._sources), self._weights
        of_layers = self._gains, self._context.table(np.array(z, self._context.dtype))
        kernel = self._at_once.kernel(TaskCode.DRIVE, "terms", self._defines)
        self._at_once.do(kernel, (out, bias, out), None, of_layers, rest, self.work)

    def do(
        self, task: TaskCode, planes: tuple[Buffer, Buffer, Buffer], sources: Callable[[ChannelSource], Buffer], *,
        before: Buffer | None = None, over: Sequence[float] = (), rounds: int = 1, **how: Any,
    ) -> tuple[float, bool]:  # fmt: skip
        """Do a task of stages.cl with (x, w, out) and all terms; see `StageTiles.do`.

        Return the largest rate or change, and whether the outputs differ from those ``before`` the last step.
        """
        tiles = self._at_once if task == TaskCode.CHECK else self._of_steps
        rest = *map(sources, self._sources), self._weights
        of_layers = self._gains, self._context.table(np.array(over or [1.0], self._context.dtype))
        kernel = tiles.kernel(task, "terms", self._defines, many=rounds > 1)
        return tiles.do(kernel, planes, before, of_layers, rest, self.work, rounds=rounds, **how)
