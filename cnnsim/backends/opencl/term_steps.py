"""Steps of a network of terms, with layers, delays and sequences: by a Runge-Kutta scheme, or in discrete time."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cnnsim.backends.base import Check, Stepper
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.channels import ChannelPlanes
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.term_table import longest_delay, table_of
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan


def term_steps(
    context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
) -> "_NetworkSteps":
    """Return the steps of a network of terms from a state; ``u`` and ``bias`` may be `Frames` of buffers."""
    return (_DiscreteLayerSteps if plan.cell == "discrete-time" else _LayerSteps)(context, plan, grid, x, u, bias, mask)


class _NetworkSteps(Stepper):
    """The channels of a network of terms, its drive of the input, its state and past states."""

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
    ) -> None:
        network, scheme = plan.network, plan.scheme
        assert network is not None
        self._context, self._plan, self._network, self._grid = context, plan, network, grid
        self._x, self._u, self._bias, self._mask = x, u, bias, mask
        tables = [table_of(plan, context.dtype, static=static) for static in (True, False)]
        self._over = 1 / np.array(network.time_constants)
        gains = [scheme.gain(plan.step * rate) if scheme else 1.0 for rate in self._over]
        self._inputs, self._states = (ChannelPlanes(context, plan, grid, tables, part, gains, mask) for part in (0, 1))
        self._past = [x] * (longest_delay(plan, network) + 1)  # before t = 0 the state was x(0)
        self._w = context.new(x.size)
        self.work = self._states.work * (len(scheme.a) if scheme else 1)
        self._z = [layer.z for layer in network.layers]

    def spans(self) -> Iterable[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        return spans(self._plan.steps, self._plan.step, delays_of(self._network), self._u, self._bias)

    def start_span(self, step: int) -> None:
        for channels in (self._inputs, self._states):
            for number, channel in enumerate(channels.table.channels):
                if channel.quantity == "u":
                    channels.fill(number, at_step(self._u, step - channel.ago, self._plan.step))
        self._inputs.drive(self._z, at_step(self._bias, step, self._plan.step), self._w)

    def _add_terms(self, task: TaskCode, x: Buffer, step: int, out: Buffer, *, at: int = 0) -> None:
        """Do a task with the drives of a state at the start of a step, and of those before it that terms look at."""
        discrete = self._plan.cell == "discrete-time"
        for number, channel in enumerate(self._states.table.channels):
            if channel.quantity != "u":
                seen = self._past[(step - channel.ago) % len(self._past)] if channel.ago else x
                self._states.fill(number, seen, output=channel.quantity == "y" and not discrete)
        self._states.add_terms(task, self._w, x, out, at=at)

    def _largest(self, name: str, *arguments: Any) -> float:
        """Return the largest number that a kernel of layers.cl hands in."""
        parts = self._context.launch(self._context.kernel(name, "stages layers", {}), self._grid.cells, *arguments)
        return float(self._context.parts(parts, self._context.dtype).max())

    def wait(self) -> None:
        self._context.queue.finish()

    def finish(self) -> Buffer:
        return self._x


class _StageSums:
    """Where a stage, or a step, leads: x + the layer's gain * sum of weight * rate; see stages.cl.

    ``rates`` has a plane for each stage; ``sizes`` are what the kernel is told last.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, sizes: tuple[Any, ...]) -> None:
        assert plan.scheme is not None
        self._context, self._grid, self._kernel = context, grid, context.kernel("layers_stage", "stages", {})
        self._rows = [
            (context.table(np.array(row or (0.0,), context.dtype)), np.int32(len(row)))
            for row in (*plan.scheme.a, plan.scheme.b)
        ]
        self._last = np.int32(plan.cell == "full-range"), np.int32(grid.cols), *sizes
        self.rates = context.new(len(plan.scheme.b) * grid.cells * context.dtype.itemsize)

    def write(self, row: int, x: Buffer, to: Buffer, mask: Buffer | None) -> None:
        """Write the state that begins stage ``row``, or with -1 that after the step."""
        self._context.launch(
            self._kernel, self._grid.cells, x, self.rates, *self._rows[row], mask, to, np.int32(mask is not None),
            *self._last,
        )  # fmt: skip


class _LayerSteps(_NetworkSteps):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, *planes: Any) -> None:
        super().__init__(context, plan, grid, *planes)
        assert plan.scheme is not None
        self._ahead = [round(sum(row)) for row in plan.scheme.a]
        layers = self._states.gains, *self._states.layer_arguments
        self._sums = _StageSums(context, plan, grid, layers)
        self._stage = context.new(self._x.size) if len(self._ahead) > 1 else None
        self._planes = [context.new(self._x.size) for _ in range(len(self._past) + 1)]

    def check_settled(self, step: int, *, last: bool) -> Check:
        context, rates, mask = self._context, self._sums.rates, self._mask
        self._add_terms(TaskCode.RATE, self._x, step, rates)
        rate = self._largest(
            "largest_rate", rates, self._x, context.table(self._over.astype(context.dtype)), mask, context.partial,
            np.int32(mask is not None), np.int32(self._plan.cell == "full-range"), np.int32(self._grid.cols),
            *self._states.layer_arguments,
        )  # fmt: skip
        return Check(rate)

    def advance(self, step: int, count: int) -> None:
        for number in range(step, step + count):
            self._past[number % len(self._past)] = self._x
            after = self._planes[number % len(self._planes)]  # the one that fell out of the past
            if self._stage is None:
                self._add_terms(TaskCode.STEP, self._x, number, after)
            else:
                for index, ahead in enumerate(self._ahead):
                    self._sums.write(index, self._x, self._stage, self._mask)
                    at = index * self._grid.cells
                    self._add_terms(TaskCode.RATE, self._stage, number + ahead, self._sums.rates, at=at)
                self._sums.write(-1, self._x, after, self._mask)
            self._x = after


class _DiscreteLayerSteps(_NetworkSteps):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, *planes: Any) -> None:
        super().__init__(context, plan, grid, x, *planes)
        self._planes = [context.new(x.size) for _ in range(len(self._past) + 2)]
        self._x = self._before = context.new(x.size)  # outputs
        self._states.add_terms(TaskCode.DISCRETE, x, x, self._x, terms=False)
        self._past = [self._x] * len(self._past)
        self._known = -1  # the step whose outputs are in its plane already

    def check_settled(self, step: int, *, last: bool) -> Check:
        after = self._after(step)
        return Check(self._change(after, self._x), repeats=step > 0 and self._change(after, self._before) == 0)

    def _change(self, a: Buffer, b: Buffer) -> float:
        return self._largest("largest_change", a, b, self._context.partial, np.int64(self._grid.cells))

    def advance(self, step: int, count: int) -> None:
        for number in range(step, step + count):
            self._before, self._x = self._x, self._after(number)

    def _after(self, number: int) -> Buffer:
        """Return the outputs after a step."""
        after = self._planes[number % len(self._planes)]  # the one that fell out of the past
        if self._known != number:
            self._past[number % len(self._past)] = self._x
            self._add_terms(TaskCode.DISCRETE, self._x, number, after)
            self._known = number
        return after
