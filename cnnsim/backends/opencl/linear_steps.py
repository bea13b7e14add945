"""Steps of a linear template by a one-stage scheme on a CPU: tile by tile, several steps a launch; sleeping tiles."""

from typing import Any

import numpy as np

from cnnsim.backends.base import CheckedStepper
from cnnsim.backends.opencl.device.build import Defines, cell_defines, literal, tap_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.opencl.settled import StripeChecks
from cnnsim.backends.opencl.tiles import cut
from cnnsim.planning.plan import Plan

ASLEEP, COASTING, AWAKE = range(3)
"""What a tile does in a launch, as in sleep.cl."""


class DeviceLinearSteps(StripeChecks, CheckedStepper):
    """Steps x += gain (A*y + w - x) from a state that is not overwritten; launches write to two planes alternately.

    With the saving "sleep" it skips tiles in which no output can change (see sleep.cl). The first two launches
    step all tiles, because each of the two planes has to be filled once.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        super().__init__(context, plan, grid, planes)
        assert plan.scheme is not None
        self._sleeps = "sleep" in plan.savings
        self._tiles = tiles = cut(context, grid, plan, small=self._sleeps)
        self._planes: list[Buffer] = []
        self._launches, self._last_steps = 0, 0
        self._moved = [context.buffer(tiles.number) for _ in range(2 * self._sleeps)]
        defines = {
            **tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, context.dtype),
            **cell_defines(plan, self._mask),
            **_fewer_loads(context, plan),
            **({"SLEEP": ""} if self._sleeps else {}),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], context.dtype),
            **tiles.defines,
        }
        self._kernel = context.kernel("steps", "boundary sleep block rows cpu", defines)
        self.together = tiles.steps

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        while count:
            steps = min(count, self._tiles.steps)
            self._launch(steps)
            count -= steps

    def _launch(self, steps: int) -> None:
        context, tiles, turn = self._context, self._tiles, self._launches % 2
        if len(self._planes) == turn:
            self._planes.append(context.plane(self._grid.cells))
        least = AWAKE if self._launches < 2 else COASTING if steps != self._last_steps else ASLEEP
        sleep: tuple[Any, ...] = (*self._moved[:: 2 * turn - 1], *tiles.around, np.int32(least)) if self._moved else ()
        for first, count in context.pieces(tiles.number, steps * self.work / tiles.number / tiles.quick):
            context.enqueue(
                self._kernel, tiles.global_size(count), tiles.local_size, self._x, self._w, self._mask,
                self._planes[turn], *tiles.arguments, np.int32(steps), np.int32(first), *sleep,
            )  # fmt: skip
        self._x = self._planes[turn]
        self._launches, self._last_steps = self._launches + 1, steps

    def wait(self) -> None:
        """See `Stepper.wait`."""
        self._context.wait()

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        return self._x


def _fewer_loads(context: DeviceContext, plan: Plan) -> Defines:
    """Return the definitions with which block.cl loads fewer neighbours; empty if the template allows none.

    Isotropic templates share sums in float32 only: float64 keeps the reference's order of sums.
    """
    if "shared sums" in plan.savings and context.dtype == np.float32:
        names = {"CENTRE": (1, 1), "EDGE": (0, 1), "CORNER": (0, 0)}
        A: Any = plan.template.A
        return {"SHARED_SUMS": "", **{name: literal(A[at], context.dtype) for name, at in names.items()}}
    sides = [tap for tap in plan.feedback_taps if tap.l]
    return {"SIDES_IN_ROW": ""} if sides and all(tap.k == 0 and abs(tap.l) == 1 for tap in sides) else {}
