"""Steps of a linear template: dx/dt = -x + A*y + w by a Runge-Kutta scheme, many a launch where it has one stage."""

from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.base import Stepper
from cnnsim.backends.codes import TaskCode, boundary_code
from cnnsim.backends.opencl.device.build import Defines, cell_defines, literal, tap_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.opencl.settled import CheckedSteps
from cnnsim.backends.opencl.stage_tiles import StageTiles, TileShape
from cnnsim.backends.opencl.tiles import TILED_BOUNDARIES, cut
from cnnsim.backends.slices import PIECE
from cnnsim.network import reach
from cnnsim.planning.plan import Plan

ASLEEP, COASTING, AWAKE = range(3)
"""What a tile does in a launch: as in sleep.cl."""
MOVED = 1
"""What a launch notes of a tile that moves; anything above: it has cells that are not saturated. As in sleep.cl."""
LOOK = 16
"""Time constants between two looks how many tiles sleep."""
FEW_RESTLESS, MOST_RESTLESS = 1 / 3, 2 / 3
"""Shares of tiles with such cells below which they are cut into light sleepers, and above which they are no more."""
QUICK = 4
"""Sums that the steps of tiles do in the time of one elsewhere: what they read is in the cache."""

MANY = 64
"""Launches after which one more, should it be the last and for nothing, is nothing beside them."""


def linear_steps(context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> Stepper:
    """Return steps by tiles, where their kernels know the scheme and the boundary, or by stages."""
    assert plan.scheme is not None
    tiled = len(plan.scheme.b) == 1 and boundary_code(plan.boundary) in TILED_BOUNDARIES
    return (_TileSteps if tiled else _StageSteps)(context, plan, grid, planes)


class _TileSteps(CheckedSteps):
    """Steps of a one-stage scheme from a state, which is left as it is: several steps a launch, ping and pong.

    With the saving "sleep", tiles in which no output can change do not look at their neighbours more than once a
    launch, and are left out when their states have come to rest (see sleep.cl). The first two launches step all of
    them, since each plane has to be filled once. On a CPU, where most of them sleep, they are cut smaller.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        super().__init__(context, plan, grid, planes)
        self._planes: list[Buffer] = []
        self._sleeps, self._turn, self._advances = "sleep" in plan.savings, 0, 0
        self._cut(light=False)

    def _cut(self, *, light: bool) -> None:
        """Go on with tiles of another size: all are awake until each plane has been filled by these."""
        context, plan = self._context, self._plan
        assert plan.scheme is not None
        self._light, self._tiles = light, cut(context, self._grid, plan, light=light)
        self.together = self._tiles.steps
        defines = {
            **tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, context.dtype),
            **cell_defines(plan, self._mask),
            **_shared_sums(context, plan),
            **({"SLEEP": ""} if self._sleeps else {}),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], context.dtype),
            **self._tiles.defines,
        }
        stems = {"cpu": "boundary sleep block rows cpu", "gpu": "boundary sleep gpu"}[context.family]
        self._kernels = [context.kernel("steps", stems, defines, twin=twin) for twin in (0, 1)]
        self._moved = [context.buffer(self._tiles.number) for _ in (0, 1)] if self._sleeps else []
        self._bound: list[tuple[Buffer, int, int, int] | None] = [None, None]
        self._launches, self._last, self._ahead = 0, 0, 0

    def advance(self, step: int, count: int) -> None:
        if self._look_is_due:
            self._look()
        self._advances += 1
        while count > 0:
            now = min(count, self._tiles.steps)
            if self._ahead != now:
                self._launch(now)
            self._x, self._turn, self._ahead = self._planes[self._turn], 1 - self._turn, 0
            self._launches, self._last = self._launches + 1, now
            count -= now

    @property
    def _look_is_due(self) -> bool:
        return self._sleeps and self._context.family == "cpu" and self._advances % LOOK == LOOK - 1

    def _look(self) -> None:
        """Go over to light sleepers where most tiles have no cell that is not saturated, and back where most have."""
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[self._turn - 1])
        restless = np.mean(found > MOVED)
        if restless > MOST_RESTLESS if self._light else restless < FEW_RESTLESS:
            self._cut(light=not self._light)

    def go_ahead(self) -> None:
        """Launch what mostly comes next: where a check or the driver will have none of it, it is left or done anew."""
        now = self._tiles.steps
        usual = self._launches >= MANY and now == self._last and now * self.work <= PIECE
        if self._moved and usual and not self._ahead and not self._look_is_due:
            self._launch(now)
            self._ahead = now

    def _launch(self, now: int) -> None:
        """Take so many steps from the state to the plane whose turn it is."""
        turn = self._turn
        if len(self._planes) == turn:
            self._planes.append(self._context.buffer(self._x.size))
        least = AWAKE if self._launches < 2 else COASTING if now != self._last else ASLEEP
        sleep: tuple[Any, ...] = (*self._moved[:: 2 * turn - 1], np.int32(least)) if self._moved else ()
        (wide, high), local = self._tiles.global_size, self._tiles.local_size
        each, work = wide // self._tiles.groups, now * self.work / self._tiles.groups / QUICK
        for first, groups in self._context.pieces(self._tiles.groups, work):
            if self._bound[turn] != (self._x, now, first, least):
                self._kernels[turn].set_args(
                    self._x, self._w, self._mask, self._planes[turn], *self._tiles.arguments, np.int32(now),
                    np.int32(first), *sleep,
                )  # fmt: skip
                self._bound[turn] = self._x, now, first, least
            self._context.enqueue(self._kernels[turn], (groups * each, high), local)

    def finish(self) -> Buffer:
        self._context.recycle(*(plane for plane in self._planes if plane is not self._x))
        return self._x


class _StageSteps(CheckedSteps):
    """Steps of any scheme with any boundary: a tile takes all stages, of a small grid all steps (see stages.cl)."""

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        super().__init__(context, plan, grid, planes)
        scheme = plan.scheme
        assert scheme is not None
        taps = plan.feedback_taps
        shape = TileShape(reach((tap.k, tap.l) for tap in taps), scheme=scheme, many=True)
        self._tiles = tiles = StageTiles(context, plan, grid, shape, scheme.gain(plan.step), planes.mask)
        offsets = [tap.k * tiles.stride + tap.l for tap in taps] or [0]
        weights = [tap.weight for tap in taps] or [0.0]
        tables = np.array(offsets, np.int32), np.array(weights, context.dtype)
        self._taps = *map(context.table, tables), np.int32(len(taps))
        stages = {"STAGES": len(scheme.b)}
        self._kernels = [tiles.kernel(TaskCode.STEP, "taps", stages, many=many) for many in (False, True)]
        self._ones = context.table(np.ones(1, context.dtype))
        self.work *= len(scheme.b)
        self._own: Buffer | None = None  # the state, once it is not the one that was given
        self._spare: Buffer | None = None

    def advance(self, step: int, count: int) -> None:
        rounds = count if self._tiles.many else 1
        for _ in range(0, count, max(1, rounds)):
            to = self._spare or self._context.buffer(self._x.size)
            planes, of_layers = (self._x, self._w, to), (self._ones, self._ones)
            self._tiles.do(self._kernels[rounds > 1], planes, None, of_layers, self._taps, self.work, rounds=rounds)
            self._x, self._own, self._spare = to, to, self._own

    def finish(self) -> Buffer:
        self._context.recycle(*([self._spare] if self._spare else []))
        return self._x


def _shared_sums(context: DeviceContext, plan: Plan) -> Defines:
    """Definitions for isotropic templates of radius 1; not in float64, which keeps the reference's order of sums."""
    if "shared sums" not in plan.savings or context.family != "cpu" or context.dtype != np.float32:
        return {}
    names = {"CENTRE": (1, 1), "EDGE": (0, 1), "CORNER": (0, 0)}
    A: Any = plan.template.A
    return {"SHARED_SUMS": "", **{name: literal(A[at], context.dtype) for name, at in names.items()}}
