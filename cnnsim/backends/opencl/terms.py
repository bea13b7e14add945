"""Terms, layers, delays and sequences on the device: planes of a run, its past states and what drives each layer."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import pyopencl as cl

from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.arguments import DeviceGrid
from cnnsim.backends.opencl.channels import ChannelPlanes
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.backends.term_table import longest_delay, table_of
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan


class LayerPlanes(NamedTuple):
    """State, input, bias and mask of a network of layers; ``u`` and ``bias`` may be `Frames` of buffers."""

    x: Buffer
    u: Any
    bias: Any
    mask: Buffer | None


class DeviceNetwork:
    """A network of terms: its channels, its drive of the input and its past states."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LayerPlanes) -> None:
        assert plan.network is not None
        self.context, self.plan, self.planes, self.grid = context, plan, planes, grid
        tables = [table_of(plan, context.dtype, static=static) for static in (True, False)]
        rates = 1 / np.array(plan.network.time_constants)
        self.gains = np.array([plan.scheme.gain(plan.step * rate) if plan.scheme else 1.0 for rate in rates])
        self.gains = self.gains.astype(context.dtype)
        self.rates = rates.astype(context.dtype)
        self._inputs, self.states = (
            ChannelPlanes(context, plan, grid, tables, part, self.gains, planes.mask) for part in (0, 1)
        )
        self._z = np.array([layer.z for layer in plan.network.layers])
        self.past = [planes.x] * (longest_delay(plan, plan.network) + 1)  # before t = 0 the state was x(0)
        self.w = self.new()

    def new(self, planes: int = 1) -> Buffer:
        """Return memory for so many planes."""
        size = planes * self.grid.cells * self.context.dtype.itemsize
        return cl.Buffer(self.context.context, cl.mem_flags.READ_WRITE, size)

    def spans(self) -> Iterable[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        plan, planes = self.plan, self.planes
        assert plan.network is not None
        return spans(plan.steps, plan.step, delays_of(plan.network), planes.u, planes.bias)

    def start_span(self, step: int) -> None:
        """Take input and bias as they are from this step on."""
        for channels in (self._inputs, self.states):
            for number, channel in enumerate(channels.table.channels):
                if channel.quantity == "u":
                    channels.fill(number, at_step(self.planes.u, step - channel.ago, self.plan.step))
        self._inputs.base(self._z, at_step(self.planes.bias, step, self.plan.step), self.w)
        self._inputs.add_terms(TaskCode.DRIVE, self.w, None, self.w)

    def fill(self, state: Buffer, step: int) -> None:
        """Bring the state at the start of a step, and those before it that terms look at, into the channels."""
        discrete = self.plan.cell == "discrete-time"
        for number, channel in enumerate(self.states.table.channels):
            if channel.quantity != "u":
                seen = self.past[(step - channel.ago) % len(self.past)] if channel.ago else state
                self.states.fill(number, seen, output=channel.quantity == "y" and not discrete)

    def largest_rate(self, rate: Buffer, x: Buffer) -> float:
        """Return the largest |dx/dt| of the free cells from the drives less the states."""
        context, mask = self.context, self.planes.mask
        return self._largest(
            "largest_rate", rate, x, context.table(self.rates), mask, context.partial, np.int32(mask is not None),
            np.int32(self.plan.cell == "full-range"), np.int32(self.grid.cols), *self.states.layer_arguments,
        )  # fmt: skip

    def largest_change(self, a: Buffer, b: Buffer) -> float:
        """Return the largest difference of two planes."""
        return self._largest("largest_change", a, b, self.context.partial, np.int64(self.grid.cells))

    def _largest(self, name: str, *arguments: Any) -> float:
        parts = self.context.launch(self.context.kernel(name, "stages layers", {}), self.grid.cells, *arguments)
        return float(self.context.parts(parts, self.context.dtype).max())
