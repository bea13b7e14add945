"""Steps of a linear template: dx/dt = -x + A*y + w by a Runge-Kutta scheme, many a launch where it has one stage."""

import numpy as np

from cnnsim.backends.base import Stepper
from cnnsim.backends.codes import TaskCode, boundary_code
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.opencl.settled import CheckedSteps
from cnnsim.backends.opencl.stage_tiles import StageTiles, TileShape
from cnnsim.backends.opencl.tile_steps import TileSteps
from cnnsim.backends.opencl.tiles import TILED_BOUNDARIES
from cnnsim.network import reach
from cnnsim.planning.plan import Plan


def linear_steps(context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> Stepper:
    """Return steps by tiles, where their kernels know the scheme and the boundary, or by stages."""
    assert plan.scheme is not None
    tiled = len(plan.scheme.b) == 1 and boundary_code(plan.boundary) in TILED_BOUNDARIES
    return (TileSteps if tiled else _StageSteps)(context, plan, grid, planes)


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
