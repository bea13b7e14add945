"""Steps of a linear template by a one-stage scheme on a GPU: patches of cells in registers (kernels/patch.cl)."""

from enum import IntFlag
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.base import Check, SettlingStepper
from cnnsim.backends.opencl.device.build import cell_defines, literal, tap_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.device.devices import family_of
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.opencl.tiles import QUICK
from cnnsim.network import reach
from cnnsim.planning.plan import SETTLED_RATE, Plan

WAIT = 16
"""Checks after which the host looks whether a large grid, or a batch, has settled."""
MOST_CHECKS = 2048
"""Checks in one launch of a grid that fits a work-group."""
_STEPS = {1: 4, 2: 2}
"""Steps of a launch on overlapping tiles, by the radius; 1 for more."""
_SHUFFLED_STEPS = 8
_SECOND = 1 << 36
"""Work of about a second on a slow GPU."""


class _Flag(IntFlag):
    """Flags of a launch, as in patch.cl."""

    ALONE = 1
    AGAIN = 2
    LAST = 4
    SATURATION_ENDS = 8


class Patch(NamedTuple):
    """Cells of a work-item (rows, cols), work-items of a group (lanes, warps), and the kind of shuffles in patch.cl."""

    rows: int
    cols: int
    lanes: int
    warps: int
    shuffles: int = 0

    @property
    def tile(self) -> tuple[int, int]:
        """Rows and columns of a group."""
        return self.rows * self.warps, self.cols * self.lanes

    def holds(self, grid: DeviceGrid) -> bool:
        """Return whether a grid fits a group."""
        return grid.rows <= self.tile[0] and grid.cols <= self.tile[1]


TEST_PATCH = Patch(4, 4, 8, 4)
"""Small on a device that is no GPU: the kernels are only tested there."""
_PATCHES = Patch(1, 1, 8, 8), Patch(1, 1, 16, 16), Patch(2, 2, 16, 16), Patch(4, 4, 16, 16)
_SHUFFLED = Patch(16, 4, 32, 8, shuffles=1)


def choose_patch(context: DeviceContext, plan: Plan, grid: DeviceGrid, radius: int) -> Patch:
    """Return the smallest patch whose group holds a grid; for larger grids the largest."""
    if family_of(context.device) != "gpu":
        return TEST_PATCH
    fitting = next((patch for patch in _PATCHES if patch.holds(grid)), None)
    plain = context.dtype == np.float32 and radius == 1 and "NVIDIA" in context.device.platform.name
    if fitting is None and plain and not (plan.boundary.kind == "periodic" and _SHUFFLED.holds(grid)):
        return _SHUFFLED  # a torus in one tile reads columns that no work-item next to it has
    patch = fitting or _PATCHES[-1]
    while patch.lanes * patch.warps > context.device.max_work_group_size:
        patch = patch._replace(warps=patch.warps // 2)
    return patch


class PatchSteps(SettlingStepper):
    """Steps from a state that is not overwritten; launches write to two planes alternately.

    A grid that fits a work-group takes all steps of a slice in one launch; larger ones a few steps a launch.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        assert plan.scheme is not None
        self._context, self._plan, self._grid = context, plan, grid
        self._x, self._w, self._mask = planes
        self._planes: list[Buffer] = []
        radius = reach((tap.k, tap.l) for tap in plan.feedback_taps)
        patch = choose_patch(context, plan, grid, radius)
        self._fits = patch.holds(grid)
        blocked = "blocking" in plan.savings
        most = (_SHUFFLED_STEPS if patch.shuffles else _STEPS.get(radius, 1)) if blocked else 1
        halo = 0 if self._fits else most * radius
        side = -(-halo // 4) * 4 if patch.shuffles else halo
        high, wide = patch.tile
        across, down = -(-grid.cols // (wide - 2 * side)), -(-grid.rows // (high - 2 * halo))
        self._tiles, self._items = grid.grids * across * down, patch.lanes * patch.warps
        self._numbers = np.array([grid.rows, grid.cols, across, down, halo, side], np.int32)
        one_launch = blocked and (self._fits or not radius)
        self._most = max(1, plan.steps) if one_launch else most
        self.together, self.few = (1, plan.steps) if one_launch else (most, self.few)
        self.work = grid.cells * len(plan.feedback_taps) / QUICK
        settles, every = plan.duration == "settled", plan.check_every
        if settles and family_of(context.device) == "gpu":  # it never waits more often, unless that takes seconds
            self.together = max(self.together, min(WAIT * every, int(_SECOND / self.work)))
        most_checks = min(MOST_CHECKS, plan.steps // every + 1) if self._fits and self._tiles == 1 else WAIT
        self.checks = most_checks if settles else 0
        self._record = context.plane(self.checks + 2 + 2 * self._tiles) if settles else self._w
        defines: dict[str, Any] = {
            **tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, context.dtype),
            **cell_defines(plan, self._mask), "SETTLED_RATE": literal(SETTLED_RATE, context.dtype),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], context.dtype),
            "PR": patch.rows, "PC": patch.cols, "LANES": patch.lanes, "WARPS": patch.warps,
            **({"SHUFFLES": patch.shuffles} if patch.shuffles else {}),
            **({"ON_GPU": ""} if family_of(context.device) == "gpu" else {}),
        }  # fmt: skip
        self._kernel = context.kernel("steps", "boundary patch", defines)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        while count:
            launches = -(-count // self._most)
            self._launch(now := -(-count // launches))
            count -= now

    def settle(self, step: int, count: int, *, last: bool) -> tuple[int, Check]:
        """See `SettlingStepper.settle`."""
        context, every = self._context, self._plan.check_every
        phase = -step % every
        flags = _Flag.SATURATION_ENDS if self._plan.saturation_ends else _Flag(0)
        at = [*range(phase, count, every), *([count] if last else [])]  # steps before which there is a check
        context.clear(self._record, -(-(self.checks + 2) // 2) * 8)
        before: list[Buffer] = []
        if self._fits and count:
            flags |= _Flag.LAST if last else _Flag(0)
            given = self._x
            self._launch(count, every, phase, 0, flags | (_Flag.ALONE if self._tiles == 1 else _Flag(0)))
            if self._tiles > 1 and at:  # the grids wait for the last one: now the step in which it settled is known
                x, self._x = self._x, given
                self._launch(count, every, phase, 0, flags | _Flag.AGAIN | _Flag.LAST, out=x)
        else:
            self._some(min(phase, count), -1)
            for number, first in enumerate(at):
                before.append(self._x)
                self._some(min(every, count - first), number, every, flags)
            if last:
                self._launch(0, every, 0, len(at) - 1, flags | _Flag.LAST)
                self._x = before[-1]
        record = context.read(self._record, np.empty(self.checks + 2 + 2 * self._tiles, context.dtype))
        words = record.view(np.int32)[: len(at)]
        ended = (words & 1 == 0) | (flags & _Flag.SATURATION_ENDS != 0) & (words & 2 == 0)
        rate, loose = record[self.checks + 2 :].reshape(-1, 2).max(axis=0).tolist()
        if not ended.any():
            return count, Check(rate)
        number = int(ended.argmax())
        if before:
            self._x = before[number]
        return at[number], Check(rate, self._plan.saturation_ends and not loose)

    def _some(self, steps: int, number: int, every: int = 0, flags: int = 0) -> None:
        """Take steps up to the next check on tiles; the first launch does check ``number``, if there is one."""
        while steps:
            now = -(-steps // -(-steps // self._most))
            self._launch(now, every, 0, number if every else number + 1, flags)
            steps, every = steps - now, 0

    def _launch(
        self, steps: int, every: int = 0, phase: int = 0, check: int = 0, flags: int = 0, *, out: Buffer | None = None
    ) -> None:
        """Launch ``steps`` steps from the present plane to the other one, or to ``out``."""
        context = self._context
        if out is None:
            if len(self._planes) < 2:
                self._planes.append(context.plane(self._grid.cells))
            out = self._planes[-1] if self._planes[-1] is not self._x else self._planes[0]
        for first, count in context.pieces(self._tiles, steps * self.work / self._tiles):
            numbers = map(np.int32, (steps, first, every, phase, check, int(flags), self.checks + 2))
            context.enqueue(
                self._kernel, (count * self._items,), (self._items,), self._x, self._w, self._mask, out, self._record,
                *self._numbers, *numbers,
            )  # fmt: skip
        self._x = out

    def wait(self) -> None:
        """See `Stepper.wait`."""
        self._context.wait()

    def finish(self) -> Buffer:
        """See `Stepper.finish`."""
        return self._x
