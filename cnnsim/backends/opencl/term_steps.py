"""Steps of a network of terms: by a Runge-Kutta scheme, or in discrete time."""

import numpy as np

from cnnsim.backends.base import Check
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.context import Buffer
from cnnsim.backends.opencl.terms import DeviceNetwork
from cnnsim.planning.plan import SETTLED_RATE


class LayerSteps:
    """A `Stepper` for dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: DeviceNetwork) -> None:
        plan, context = network.plan, network.context
        assert plan.scheme is not None
        self._network, self._x = network, network.planes.x
        self._ahead = [round(sum(row)) for row in plan.scheme.a]
        *self._rows, self._last = (
            (np.int32(len(row)), context.table(np.array(row or [0.0], context.dtype)))
            for row in (*plan.scheme.a, plan.scheme.b)
        )
        self._sum = context.kernel("layers_stage", "stages", {})
        self._gains = context.table(network.gains)
        self._rates = network.new(len(self._rows))
        self._stage = network.new() if len(self._rows) > 1 else None
        self._planes = [network.new() for _ in range(len(network.past) + 1)]

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        network = self._network
        network.fill(self._x, step)
        network.states.add_terms(TaskCode.RATE, network.w, self._x, self._rates)
        return Check(network.largest_rate(self._rates, self._x))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        network = self._network
        for number in range(step, step + count):
            network.past[number % len(network.past)] = self._x
            after = self._planes[number % len(self._planes)]  # the one that fell out of the past
            if self._stage is None:
                network.fill(self._x, number)
                network.states.add_terms(TaskCode.EULER, network.w, self._x, after)
            else:
                self._stages(self._stage, number)
                self._go(self._last, after, network.planes.mask)
            self._x = after

    def _stages(self, stage: Buffer, number: int) -> None:
        network = self._network
        for index, (row, ahead) in enumerate(zip(self._rows, self._ahead, strict=True)):
            self._go(row, stage, None)
            network.fill(stage, number + ahead)
            network.states.add_terms(TaskCode.RATE, network.w, stage, self._rates, at=index * network.grid.cells)

    def _go(self, row: tuple[np.int32, Buffer], to: Buffer, mask: Buffer | None) -> None:
        """Write x + gain * sum of weight * rate to a plane."""
        network, (stages, weights) = self._network, row
        network.context.launch(
            self._sum, network.grid.cells, self._x, self._rates, weights, stages, mask, to, np.int32(mask is not None),
            np.int32(network.plan.cell == "full-range"), np.int32(network.grid.cols), self._gains,
            *network.states.layer_arguments,
        )  # fmt: skip

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        return self._x


class DiscreteLayerSteps:
    """A `Stepper` for y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: DeviceNetwork) -> None:
        self._network = network
        self._planes = [network.new() for _ in range(len(network.past) + 2)]
        self._y = self._before = network.new()
        network.states.add_terms(TaskCode.DISCRETE, network.planes.x, network.planes.x, self._y, terms=False)
        network.past = [self._y] * len(network.past)
        self._known = -1  # the step whose outputs are in its plane already

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        network, after = self._network, self._after(step)
        change = network.largest_change(after, self._y)
        settled = change <= SETTLED_RATE
        return Check(change, repeats=not settled and step > 0 and network.largest_change(after, self._before) == 0)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        for number in range(step, step + count):
            self._before, self._y = self._y, self._after(number)

    def _after(self, number: int) -> Buffer:
        """Return the outputs after a step."""
        network = self._network
        after = self._planes[number % len(self._planes)]  # the one that fell out of the past
        if self._known != number:
            network.past[number % len(network.past)] = self._y
            network.fill(self._y, number)
            network.states.add_terms(TaskCode.DISCRETE, network.w, self._y, after)
            self._known = number
        return after

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        return self._y
