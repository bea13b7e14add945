"""Whether a linear template has settled: its largest |dx/dt|, and whether every output is saturated for good."""

from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.backends.base import Check
from cnnsim.backends.opencl.control import tap_arguments
from cnnsim.backends.opencl.device.build import boundary_defines, cell_defines
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.planning.plan import SETTLED_RATE, Plan

STRIPES, STRIPE_CELLS = 16, 16_384
"""The most stripes in a check (a stripe is a range of rows), and the fewest cells in a stripe."""


class StripeChecks:
    """Checks of a state stripe by stripe, until a stripe shows that the network has not settled.

    The next check begins at that stripe, because its cells probably still change.
    """

    def __init__(self, context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> None:
        self._context, self._plan, self._grid = context, plan, grid
        self._x, self._w, self._mask = planes
        stripes = max(1, min(STRIPES, grid.cells // STRIPE_CELLS))
        self._ends = [grid.lines * stripe // stripes for stripe in range(stripes + 1)]
        self._stripe = 0
        self.work: float = grid.cells * len(plan.feedback_taps)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """Check the state; the rate is the largest of the stripes checked. The ``last`` check reads all stripes."""
        largest, unsaturated, saturation_ends = 0.0, False, self._plan.saturation_ends
        for _ in self._ends[1:]:
            rate, here = self._check_stripe()
            largest = float(np.maximum(rate, largest))  # NaN stays
            unsaturated |= here
            if not last and not largest <= SETTLED_RATE and (unsaturated or not saturation_ends):
                return Check(largest)
            self._stripe = (self._stripe + 1) % (len(self._ends) - 1)
        return Check(largest, saturation_ends and not unsaturated)

    @cached_property
    def _kernel_and_taps(self) -> tuple[Any, ...]:  # built only where the transient is to settle
        defines = {**boundary_defines(self._plan.boundary), **cell_defines(self._plan, self._mask), "SETTLED": ""}
        taps = tap_arguments(self._context, self._plan.feedback_taps, self._plan.boundary.y)
        return self._context.kernel("check_settled", "boundary stencil", defines), *taps

    def _check_stripe(self) -> tuple[float, bool]:
        first, end = self._ends[self._stripe : self._stripe + 2]
        (kernel, *taps), (_, *size), context = self._kernel_and_taps, self._grid.arguments, self._context
        parts = context.launch(
            kernel, (end - first) * self._grid.cols, self._x, self._w, self._mask, context.partial,
            np.int64(first), *taps, np.int64(end - first), *size,
        )  # fmt: skip
        rate, unsaturated = context.parts(2 * parts, context.dtype).reshape(-1, 2).max(axis=0).tolist()
        return rate, bool(unsaturated)
