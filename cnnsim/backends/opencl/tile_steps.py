"""Steps of a one-stage scheme by tiles: several a launch, several launches and checks ahead where tiles sleep."""

from collections import deque
from typing import Any, NamedTuple

import numpy as np
import pyopencl as cl

from cnnsim.backends.base import Check
from cnnsim.backends.opencl.device.build import Defines, cell_defines, literal, tap_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.opencl.settled import CheckedSteps
from cnnsim.backends.opencl.tiles import cut
from cnnsim.backends.slices import PIECE
from cnnsim.planning.plan import SETTLED_RATE, Plan

ASLEEP, COASTING, AWAKE = range(3)
"""What a tile does in a launch: as in sleep.cl."""
MOVED = 1
"""What a launch notes of a tile that moves; anything above: it has cells that are not saturated. As in sleep.cl."""
LOOK = 8
"""Times that steps are asked for between two looks how many tiles sleep."""
FEW_RESTLESS, MOST_RESTLESS = 1 / 2, 2 / 3
"""Shares of tiles with such cells below which they are cut into light sleepers, and above which they are no more."""
LEAST_LIGHT = 1 << 18
"""Cells below which they are not: to build their kernel takes longer than it saves in several runs."""
QUICK = 4
"""Sums that the steps of tiles do in the time of one elsewhere: what they read is in the cache."""

AHEAD = 8
"""The most checks, with the steps after each, that a CPU is given at once."""
MANY = 16
"""Launches beside which those that follow one check, should they be for nothing, are nothing."""

_COPIED = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR


class _State(NamedTuple):
    """Where launches have come to: the state, the plane whose turn it is, how many they were, the steps of the last."""

    x: Buffer
    turn: int = 0
    launches: int = 0
    last: int = 0


class TileSteps(CheckedSteps):
    """Steps of a one-stage scheme from a state, which is left as it is: several steps a launch, ping and pong.

    With the saving "sleep", tiles in which no output can change do not look at their neighbours more than once a
    launch, and are left out when their states have come to rest (see sleep.cl). The first two launches step all of
    them, since each plane has to be filled once. On a CPU, where most of them sleep, they are cut smaller.

    Such launches are over sooner than they are asked for, so they are asked for ahead, with the checks between them;
    on a CPU those after a check that may have found the network at rest do nothing.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        super().__init__(context, plan, grid, planes)
        self._planes: list[Buffer] = []
        self._sleeps, self._advances, self._next_look = "sleep" in plan.savings, 0, LOOK - 1
        self._gated = self._sleeps and context.family == "cpu"
        self._went_on, self._found = 0, np.zeros(2, np.int32)
        self._halt = cl.Buffer(context.context, _COPIED, hostbuf=self._found)  # as in sleep.cl
        self._reading: cl.Event | None = None
        self._state, self._ahead, self._beyond = _State(self._x), deque[_State](), 0
        self._step, self._rate = 0, np.nan
        self._cut(light=False)

    def _cut(self, *, light: bool) -> None:
        """Go on with tiles of another size: all are awake until each plane has been filled by these."""
        context, plan = self._context, self._plan
        assert plan.scheme is not None
        self._light, self._tiles = light, cut(context, self._grid, plan, light=light)
        self.together = self._tiles.steps
        rest: Defines = {"REST": literal(SETTLED_RATE, context.dtype), "SATURATION_ENDS": int(plan.saturation_ends)}
        defines = {
            **tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, context.dtype),
            **cell_defines(plan, self._mask),
            **_shared_sums(context, plan),
            **({"SLEEP": ""} if self._sleeps else {}),
            **(rest if self._gated else {}),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], context.dtype),
            **self._tiles.defines,
        }
        stems = {"cpu": "boundary sleep block rows cpu", "gpu": "boundary sleep gpu"}[context.family]
        self._kernels = [context.kernel("steps", stems, defines, twin=twin) for twin in (0, 1)]
        self._moved = [context.buffer(self._tiles.number) for _ in (0, 1)] if self._sleeps else []
        self._state = self._state._replace(launches=0, last=0)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        self._collect()
        self._look_if_due()
        self._advances += 1
        while self._beyond < count:
            if not self._ahead:
                self._ahead.append(self._launch(self._state, min(count - self._beyond, self._tiles.steps)))
            self._state = self._ahead.popleft()
            self._x, self._beyond = self._state.x, self._beyond + self._state.last
        self._beyond -= count

    def _look_if_due(self) -> None:
        """Go over to light sleepers where most tiles have no cell that is not saturated, and back where most have."""
        if self._grid.cells < LEAST_LIGHT or not self._gated or self._ahead or self._advances < self._next_look:
            return
        self._next_look = self._advances + LOOK
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[self._state.turn - 1])
        restless = np.mean(found > MOVED)
        if restless > MOST_RESTLESS if self._light else restless < FEW_RESTLESS:
            self._cut(light=not self._light)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedSteps.check_settled`; where launches after this check went on, it has shown what moves."""
        self._collect()
        if self._ahead:
            return Check(self._rate)
        self._look_if_due()
        self._step = step
        check = super().check_settled(step, last=last)
        self._rate = check.rate
        return check

    def go_ahead(self, parts: int) -> None:
        """Launch what mostly comes next: where a check or the driver will have none of it, it is left or done anew."""
        state, now, left = self._state, self._tiles.steps, self._plan.steps - self._step
        usual = state.launches >= MANY and now == state.last and now * self.work <= PIECE
        if self._ahead or not (self._moved and usual and now <= left):
            return
        if not self._gated:
            self._ahead.append(self._launch(state, now))
            return
        every = self._plan.check_every
        checks = min(AHEAD, state.launches // MANY, left // every)
        for check in range(checks):
            parts = self._launch_check(state.x) if check else parts
            for first in range(0, every, now):
                state = self._launch(state, min(now, every - first), parts)
                self._ahead.append(state)
        if checks:
            self._reading = cl.enqueue_copy(self._context.queue, self._found, self._halt, is_blocking=False)

    def _collect(self) -> None:
        """Wait for what was launched ahead, and forget those launches that did nothing."""
        if self._reading is None:
            return
        self._reading.wait()
        halted, went_on = self._found.tolist()
        while len(self._ahead) > went_on - self._went_on:
            self._ahead.pop()
        self._reading, self._went_on = None, went_on
        if halted:
            self._went_on = 0
            cl.enqueue_copy(self._context.queue, self._halt, np.zeros(2, np.int32))

    def _launch(self, state: _State, now: int, parts: int = 0) -> _State:
        """Take so many steps to the plane whose turn it is; with ``parts`` of a check, if all checks so far let it."""
        turn, x = state.turn, state.x
        if len(self._planes) == turn:
            self._planes.append(self._context.buffer(x.size))
        least = AWAKE if state.launches < 2 else COASTING if now != state.last else ASLEEP
        sleep: tuple[Any, ...] = (*self._moved[:: 2 * turn - 1], np.int32(least)) if self._moved else ()
        gate = (self._halt, self._context.partial, np.int32(parts)) if self._gated else ()
        (wide, high), local = self._tiles.global_size, self._tiles.local_size
        each, work = wide // self._tiles.groups, now * self.work / self._tiles.groups / QUICK
        for first, groups in self._context.pieces(self._tiles.groups, work):
            self._context.bind(
                self._kernels[turn], x, self._w, self._mask, self._planes[turn], *self._tiles.arguments, np.int32(now),
                np.int32(first), *sleep, *gate,
            )  # fmt: skip
            self._context.enqueue(self._kernels[turn], (groups * each, high), local)
        return _State(self._planes[turn], 1 - turn, state.launches + 1, now)

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        self._context.recycle(*(plane for plane in self._planes if plane is not self._x))
        return self._x


def _shared_sums(context: DeviceContext, plan: Plan) -> Defines:
    """Definitions for isotropic templates of radius 1; not in float64, which keeps the reference's order of sums."""
    if "shared sums" not in plan.savings or context.family != "cpu" or context.dtype != np.float32:
        return {}
    names = {"CENTRE": (1, 1), "EDGE": (0, 1), "CORNER": (0, 0)}
    A: Any = plan.template.A
    return {"SHARED_SUMS": "", **{name: literal(A[at], context.dtype) for name, at in names.items()}}
