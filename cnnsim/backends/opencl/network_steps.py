"""Steps of networks of terms by any scheme or in discrete time; of linear templates by schemes of several stages."""

from collections.abc import Iterable
from typing import Any

from cnnsim.backends.base import Check, CheckedStepper
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.network_planes import Neighbours, NetworkPlanes, NetworkTask, of_taps, of_terms
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.term_table import table_of
from cnnsim.network import reach
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan


class _PaddedSteps(CheckedStepper):
    """Steps in padded planes: a launch a stage, or for small grids one launch for many steps."""

    _task = NetworkTask.STEP
    _neighbours: Neighbours

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: NetworkPlanes, x: Buffer) -> None:
        self._context, self._plan, self._grid, self._planes = context, plan, grid, planes
        self._now = 0
        for number in (0, *range(2, planes.past)):  # before t = 0 the state was x(0)
            planes.padded.pad(x, planes.x, number, plan.boundary.y)
            planes.do(NetworkTask.OUTPUT, self._neighbours, number)
        self.work = grid.cells * self._neighbours.sums * planes.stages

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        stages = self._planes.stages
        turns = stages * count if self._planes.padded.whole else 1
        for turn in range(0, stages * count, max(1, turns)):
            self._planes.do(self._task, self._neighbours, step + turn // stages, turn % stages, turns)
        self._now = step + count

    def wait(self) -> None:
        """See `Stepper.wait`."""
        self._context.wait()

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        out = self._context.plane(self._grid.cells)
        self._planes.padded.unpad(self._planes.x, self._now % self._planes.past, out)
        return out


class LinearStageSteps(_PaddedSteps):
    """Steps of a linear template by a scheme of several stages."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, given: LinearPlanes) -> None:
        radius = reach((tap.k, tap.l) for tap in plan.feedback_taps)
        planes = NetworkPlanes(context, plan, grid, radius, mask=given.mask)
        planes.padded.pad(given.w, planes.w, 0, 0.0)
        self._neighbours = of_taps(context, plan, planes.padded.stride)
        super().__init__(context, plan, grid, planes, given.x)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        rate, unsaturated = self._planes.measure(NetworkTask.CHECK, self._neighbours, step)
        return Check(rate, self._plan.saturation_ends and not unsaturated)


class NetworkSteps(_PaddedSteps):
    """Steps of dx/dt = (drive - x) / T with layers, delays and sequences; ``u`` and ``bias`` may be `Frames`."""

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
    ) -> None:
        network = plan.network
        assert network is not None
        self._network, self._u, self._bias = network, u, bias
        still, moving = (table_of(plan, context.dtype, static=static) for static in (True, False))
        channels = (*still.channels, *moving.channels)
        self._delays = sorted({channel.ago for channel in channels if channel.quantity == "u"})
        self._drive = of_terms(context, plan, still, self._delays, output=False)
        self._neighbours = of_terms(context, plan, moving, self._delays)
        planes = NetworkPlanes(
            context, plan, grid, max(still.radius, moving.radius), mask=mask, inputs=len(self._delays),
            delay=max((channel.ago for channel in moving.channels if channel.quantity != "u"), default=0),
            z=[layer.z for layer in network.layers],
        )  # fmt: skip
        super().__init__(context, plan, grid, planes, x)

    def spans(self) -> Iterable[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias do not change."""
        return spans(self._plan.steps, self._plan.step, delays_of(self._network), self._u, self._bias)

    def start_span(self, step: int) -> None:
        """See `CheckedStepper.start_span`."""
        planes, plan = self._planes, self._plan
        for number, delay in enumerate(self._delays):
            planes.padded.pad(at_step(self._u, step - delay, plan.step), planes.u, number, plan.boundary.u)
        planes.set_bias(at_step(self._bias, step, plan.step))
        planes.do(NetworkTask.DRIVE, self._drive)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        return Check(self._planes.measure(NetworkTask.CHECK, self._neighbours, step)[0])


class DeviceDiscreteSteps(NetworkSteps):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    _task = NetworkTask.DISCRETE
    _checked = -1  # the step that a check has taken already

    def check_settled(self, step: int, *, last: bool) -> Check:
        """Take the step and measure the change; see `CheckedStepper.check_settled`."""
        change, differs = self._planes.measure(NetworkTask.CHECK_DISCRETE, self._neighbours, step)
        self._checked = step
        return Check(change, repeats=step > 0 and not differs)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        known = int(count > 0 and self._checked == step)
        super().advance(step + known, count - known)
