"""Whether a linear template has settled: its largest |dx/dt|, and whether every output is saturated for good."""

import numpy as np

from cnnsim.backends.base import Check
from cnnsim.backends.opencl.build import boundary_defines, cell_defines
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.backends.opencl.drive import tap_arguments
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.planning.plan import SETTLED_RATE, Plan

STRIPES, STRIPE_CELLS = 16, 16_384
"""The most stripes that a check may take one by one, and the fewest cells in one."""


class StripedCheck:
    """Checks stripe by stripe of lines, until one shows that the network has not settled.

    The next check begins where the last one ended: what moved there will mostly be moving still.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        self._context, self._grid, self._w, self._mask = context, grid, planes.w, planes.mask
        defines = {**boundary_defines(plan.boundary), **cell_defines(plan, planes.mask), "SETTLED": ""}
        self._kernel = context.kernel("check_settled", "boundary stencil", defines)
        self._taps = tap_arguments(context, plan.feedback_taps, plan.boundary.y)
        self._saturation_ends = plan.saturation_ends
        stripes = max(1, min(STRIPES, grid.cells // STRIPE_CELLS))
        self._ends = [grid.lines * stripe // stripes for stripe in range(stripes + 1)]
        self._at = 0

    def check(self, x: Buffer, *, whole: bool) -> Check:
        """Check a state; the rate is that of the stripes this took, or, of the ``whole``, of all."""
        largest, unsaturated = 0.0, False
        for _ in self._ends[1:]:
            rate, here = self._stripe(x)
            largest = float(np.maximum(rate, largest))  # NaN comes through
            unsaturated |= here
            if not whole and not largest <= SETTLED_RATE and (unsaturated or not self._saturation_ends):
                return Check(largest)
            self._at = (self._at + 1) % (len(self._ends) - 1)
        return Check(largest, self._saturation_ends and not unsaturated)

    def _stripe(self, x: Buffer) -> tuple[float, bool]:
        first, end = self._ends[self._at : self._at + 2]
        context, _, *size = self._context, *self._grid.arguments
        parts = context.launch(
            self._kernel, (end - first) * self._grid.cols, x, self._w, self._mask, context.partial, np.int64(first),
            *self._taps, np.int64(end - first), *size,
        )  # fmt: skip
        rate, unsaturated = context.parts(2 * parts, context.dtype).reshape(parts, 2).max(axis=0).tolist()
        return rate, bool(unsaturated)
