"""Looks at a network on the device: what still moves, and what all kernels of opencl_stencil.cl need to be told."""

from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.build import Workshop, boundary_defines, radius_of
from cnnsim.network.template import Tap
from cnnsim.planning.plan import SETTLED_RATE, Plan

Buffer = cl.Buffer
Shape = tuple[int, int, int]

STRIPES, STRIPE_CELLS = 16, 16_384
"""The most stripes that a look may take one by one, and the fewest cells in one."""


class Watch:
    """Looks whether the network has settled (see `Plan`), stripe by stripe of lines, until one shows that it has not.

    The next look begins where the last one ended: what moved there will mostly be moving still.
    """

    def __init__(self, shop: Workshop, plan: Plan, shape: Shape, w: Buffer, held: Buffer | None) -> None:
        grids, rows, self._cols = shape
        self._shop, self._w, self._held = shop, w, held
        mask = {} if held is None else {"HELD": ""}
        self._kernel = shop.kernel(
            "look", "stencil", {**boundary_defines(plan.boundary), **walls(plan), **mask, "LOOK": ""}
        )
        *self._taps, self._lines, self._rows, _ = stencil_arguments(shop, plan.feedback_taps, plan.boundary.y, shape)
        self._freezes = plan.cell == "chua-yang" and plan.step <= 1
        stripes = max(1, min(STRIPES, grids * rows * self._cols // STRIPE_CELLS))
        self._ends = [grids * rows * stripe // stripes for stripe in range(stripes + 1)]
        self._at = 0

    def look(self, x: Buffer, *, whole: bool) -> tuple[bool, float]:
        """Return whether the network has settled, and the largest |dx/dt| in the stripes that this took, or in all."""
        steepest, loose = 0.0, False
        for _ in self._ends[1:]:
            slope, restless = self._stripe(x)
            steepest = float(np.maximum(slope, steepest))  # NaN comes through
            loose |= restless
            if not whole and not steepest <= SETTLED_RATE and (loose or not self._freezes):
                return False, steepest
            self._at = (self._at + 1) % (len(self._ends) - 1)
        return steepest <= SETTLED_RATE or (self._freezes and not loose), steepest

    def _stripe(self, x: Buffer) -> tuple[float, bool]:
        first, end = self._ends[self._at : self._at + 2]
        lines = np.int64(end - first)
        parts = self._shop.run(
            self._kernel, (end - first) * self._cols, x, self._w, self._held, self._shop.partial, np.int64(first),
            *self._taps, lines, self._rows, np.int32(self._cols),
        )  # fmt: skip
        steepest, loose = self._shop.parts(2 * parts, self._shop.dtype).reshape(parts, 2).max(axis=0).tolist()
        return steepest, bool(loose)


def stencil_arguments(shop: Workshop, taps: tuple[Tap, ...], constant: float, shape: Shape) -> tuple[Any, ...]:
    """Return the arguments that all kernels of opencl_stencil.cl end with."""
    grids, rows, cols = shape
    return (
        *shop.tap_buffers(taps), np.int32(len(taps)), np.int32(radius_of(taps)), shop.dtype.type(constant),
        np.int64(grids * rows), np.int32(rows), np.int32(cols),
    )  # fmt: skip


def walls(plan: Plan) -> dict[str, str | int]:
    """Return the definition that keeps the states of full-range cells within +-1."""
    return {"WALLS": ""} if plan.cell == "full-range" else {}
