"""Steps of a network of terms, with layers, delays and sequences: by a Runge-Kutta scheme, or in discrete time."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from cnnsim.backends.base import Check, Stepper
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.opencl.channel_text import ChannelSource
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.term_tiles import TermTiles
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
    """The tiles of a network of terms, its drive of the input, its state and past states.

    States lie in one plane more than are looked at, by turns; a plane is made when its turn comes first.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
    ) -> None:
        network, scheme = plan.network, plan.scheme
        assert network is not None
        self._context, self._plan, self._network = context, plan, network
        self._x, self._u, self._bias = x, u, bias
        still, moving = (table_of(plan, context.dtype, static=static) for static in (True, False))
        self._over = [float(rate) for rate in 1 / np.array(network.time_constants)]
        gains = [scheme.gain(plan.step * rate) if scheme else 1.0 for rate in self._over]
        self._drive = TermTiles(context, plan, grid, still)
        self._tiles = TermTiles(context, plan, grid, moving, gains, mask)
        self._past = [x] * (longest_delay(plan, network) + 1)  # before t = 0 the state was x(0)
        self._planes: list[Buffer] = []
        self._w = context.buffer(x.size)
        self.work = self._tiles.work * (len(scheme.a) if scheme else 1)
        self._z, self._span = [layer.z for layer in network.layers], 0
        self._turn = 0  # launches so far, each of which wrote a plane

    def spans(self) -> Iterable[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        return spans(self._plan.steps, self._plan.step, delays_of(self._network), self._u, self._bias)

    def start_span(self, step: int) -> None:
        self._span = step
        self._drive.drive(self._z, at_step(self._bias, step, self._plan.step), self._w, self._input)

    def _input(self, source: ChannelSource) -> Any:
        return at_step(self._u, self._span - source.ago, self._plan.step)

    def _do(self, task: TaskCode, step: int, out: Buffer, **more: Any) -> tuple[float, bool]:
        """Do a task with the state at the start of a step."""

        def plane(source: ChannelSource) -> Buffer:
            past = self._past[(step + source.late - source.ago) % len(self._past)]
            return self._input(source) if source.input else past

        return self._tiles.do(task, (self._x, self._w, out), plane, **more)

    def _launches(self, step: int, count: int) -> Iterator[tuple[int, int]]:
        """Yield (first step, steps) of the launches for some steps."""
        rounds = count if self._tiles.many else 1
        return ((number, rounds) for number in range(step, step + count, max(1, rounds)))

    def _next_plane(self) -> Buffer:
        """Return the plane for the next state: of those that were, the one that fell out of the past."""
        turn = self._turn % (len(self._past) + 1)
        if len(self._planes) <= turn:
            self._planes.append(self._context.buffer(self._x.size))
        self._turn += 1
        return self._planes[turn]

    def wait(self) -> None:
        self._context.queue.finish()

    def finish(self) -> Buffer:
        self._context.recycle(self._w, *(plane for plane in self._planes if plane is not self._x))
        return self._x


class _LayerSteps(_NetworkSteps):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def check_settled(self, step: int, *, last: bool) -> Check:
        return Check(self._do(TaskCode.CHECK, step, self._x, over=self._over, measured=True)[0])

    def advance(self, step: int, count: int) -> None:
        for number, rounds in self._launches(step, count):
            self._past[number % len(self._past)] = self._x
            after = self._next_plane()
            self._do(TaskCode.STEP, number, after, rounds=rounds)
            self._x = after


class _DiscreteLayerSteps(_NetworkSteps):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, *planes: Any) -> None:
        super().__init__(context, plan, grid, x, *planes)
        outputs = self._next_plane()
        self._tiles.do(TaskCode.DISCRETE, (x, x, outputs), lambda _: x, bare=True)
        self._x = self._before = self._after = outputs
        self._past = [outputs] * len(self._past)
        self._known = -1  # the step whose outputs are in its plane already

    def check_settled(self, step: int, *, last: bool) -> Check:
        change, differs = self._step(step, before=self._before, measured=True)
        return Check(change, repeats=step > 0 and not differs)

    def advance(self, step: int, count: int) -> None:
        known = int(count > 0 and self._known == step)
        if known:
            self._before, self._x = self._x, self._after
        for number, rounds in self._launches(step + known, count - known):
            self._step(number, rounds=rounds)
            self._before, self._x = self._x, self._after

    def _step(self, number: int, **how: Any) -> tuple[float, bool]:
        """Write the outputs after a step, perhaps over those before it; return how they differ, if it is measured."""
        self._past[number % len(self._past)] = self._x
        self._known, self._after = number, self._next_plane()
        return self._do(TaskCode.DISCRETE, number, self._after, **how)
