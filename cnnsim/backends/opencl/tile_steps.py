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

ROUNDS = 64
"""The most rounds in a launch, as in rounds.cl."""
PATIENCE = 1 << 14
"""Looks for work until an item leaves the others alone with a launch: about a tenth of a millisecond."""
MANY = 16
"""Launches beside which one ahead of a check, should it be for nothing, is nothing."""
_SIGNS = 4  # numbers of a book before those of its rounds, as in rounds.cl

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

    Such launches are over sooner than they are asked for. So a CPU takes many in one, as rounds, and looks itself
    whether a cell moves (see rounds.cl); a GPU is given one ahead of each check.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        super().__init__(context, plan, grid, planes)
        self._planes: list[Buffer] = []
        self._sleeps, self._advances, self._next_look = "sleep" in plan.savings, 0, LOOK - 1
        self._by_rounds = self._sleeps and context.family == "cpu"
        self._book = cl.Buffer(context.context, _COPIED, hostbuf=np.zeros(_SIGNS + ROUNDS, np.int32))
        self._state, self._ahead, self._beyond = _State(self._x), deque[_State](), 0
        self._step, self._rate = 0, np.nan
        self._cut(light=False)

    def _cut(self, *, light: bool) -> None:
        """Go on with tiles of another size: all are awake until each plane has been filled by these."""
        context, plan = self._context, self._plan
        assert plan.scheme is not None
        self._light, self._tiles = light, cut(context, self._grid, plan, light=light)
        self.together = self._tiles.steps
        rest, ends = literal(SETTLED_RATE, context.dtype), int(plan.saturation_ends)
        by_rounds: Defines = {"REST": rest, "SATURATION_ENDS": ends, "PATIENCE": PATIENCE}
        defines = {
            **tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, context.dtype),
            **cell_defines(plan, self._mask),
            **_fewer_loads(context, plan),
            **({"SLEEP": ""} if self._sleeps else {}),
            **(by_rounds if self._by_rounds else {}),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], context.dtype),
            **self._tiles.defines,
        }
        stems = {"cpu": "boundary sleep block rounds rows cpu", "gpu": "boundary sleep gpu"}[context.family]
        self._kernels = [context.kernel("steps", stems, defines, twin=twin) for twin in (0, 1)]
        self._moved = [context.buffer(self._tiles.number) for _ in (0, 1)] if self._sleeps else []
        self._state = self._state._replace(launches=0, last=0)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        self._look_if_due()
        self._advances += 1
        while self._beyond < count:
            if not self._ahead:
                self._go_on(step + self._beyond, count - self._beyond)
            self._state = self._ahead.popleft()
            self._x, self._beyond = self._state.x, self._beyond + self._state.last
        self._beyond -= count

    def _go_on(self, step: int, count: int) -> None:
        """Launch what comes next: so many steps or a part of them; on a CPU many rounds, with looks in between."""
        state, now, every = self._state, min(count, self._tiles.steps), self._plan.check_every
        rounds, each = 1, every // now
        if self._by_rounds and state.launches >= 2 and now == state.last and count == every == each * now:
            most = min(ROUNDS, (self._plan.steps - step) // now, int(PIECE * QUICK / (now * self.work)))
            rounds = max(1, most // each * each)
        self._launch(state, now, rounds, each)
        if rounds > 1:
            went_on = np.empty(1, np.int32)
            cl.enqueue_copy(self._context.queue, went_on, self._book, src_offset=went_on.nbytes * (_SIGNS - 1))
            rounds = int(went_on[0])
        for _ in range(rounds):
            state = _State(self._planes[state.turn], 1 - state.turn, state.launches + 1, now)
            self._ahead.append(state)

    def _look_if_due(self) -> None:
        """Go over to light sleepers where most tiles have no cell that is not saturated, and back where most have."""
        if self._grid.cells < LEAST_LIGHT or not self._by_rounds or self._ahead or self._advances < self._next_look:
            return
        self._next_look = self._advances + LOOK
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[self._state.turn - 1])
        restless = np.mean(found > MOVED)
        if restless > MOST_RESTLESS if self._light else restless < FEW_RESTLESS:
            self._cut(light=not self._light)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedSteps.check_settled`; where launches after this check went on, it has shown what moves."""
        if self._ahead:
            return Check(self._rate)
        self._look_if_due()
        self._step = step
        check = super().check_settled(step, last=last)
        self._rate = check.rate
        return check

    def go_ahead(self) -> None:
        """Launch what mostly comes next on a GPU: where a check or the driver will have none of it, it is left."""
        state, now, left = self._state, self._tiles.steps, self._plan.steps - self._step
        usual = state.launches >= MANY and now == state.last and now * self.work <= PIECE
        if usual and now <= left and self._sleeps and not (self._by_rounds or self._ahead):
            self._go_on(self._step, now)

    def _launch(self, state: _State, now: int, rounds: int, each: int) -> None:
        """Take so many steps to the plane whose turn it is, and so on; see rounds.cl."""
        turn, context, tiles = state.turn, self._context, self._tiles
        if len(self._planes) == turn:
            self._planes.append(context.buffer(state.x.size))
        least = AWAKE if state.launches < 2 else COASTING if now != state.last else ASLEEP
        sleep: tuple[Any, ...] = (*self._moved[:: 2 * turn - 1], np.int32(least)) if self._moved else ()
        (wide, high), kernel = tiles.global_size, self._kernels[turn]
        items, work = wide // tiles.groups, rounds * now * self.work / tiles.groups / QUICK
        for first, groups in context.pieces(tiles.groups, work):
            book = (self._book, np.int32(groups), np.int32(rounds), np.int32(each)) if self._by_rounds else ()
            context.bind(
                kernel, state.x, self._w, self._mask, self._planes[turn], *tiles.arguments, np.int32(now),
                np.int32(first), *sleep, *book,
            )  # fmt: skip
            workers = min(groups, context.cores) if self._by_rounds else groups
            context.enqueue(kernel, (workers * items, high), tiles.local_size)

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        self._context.recycle(*(plane for plane in self._planes if plane is not self._x))
        return self._x


def _fewer_loads(context: DeviceContext, plan: Plan) -> Defines:
    """Definitions for templates of radius 1 that need not load all neighbours where they lie; see block.cl.

    Isotropic ones only in float32: float64 keeps the reference's order of sums.
    """
    if context.family != "cpu":
        return {}
    if "shared sums" in plan.savings and context.dtype == np.float32:
        names = {"CENTRE": (1, 1), "EDGE": (0, 1), "CORNER": (0, 0)}
        A: Any = plan.template.A
        return {"SHARED_SUMS": "", **{name: literal(A[at], context.dtype) for name, at in names.items()}}
    beside = [tap for tap in plan.feedback_taps if tap.l]
    return {"SIDES_IN_ROW": ""} if beside and all(tap.k == 0 and abs(tap.l) == 1 for tap in beside) else {}
