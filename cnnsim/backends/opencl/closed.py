"""The closed form of cells without neighbours."""

import math
from typing import Any

import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.backends.opencl.device.build import boundary_defines, cell_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.drive import control_taps, with_control_terms
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.slices import EXPONENTIALS
from cnnsim.planning.plan import Plan


def closed_form(
    context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
) -> tuple[Outcome, bool]:
    """Return the end of uncoupled cells, at the plan's duration or at rest, and whether all are finite."""
    settled, number, fine = plan.duration == "settled", context.dtype.type, True
    t, bias = math.inf if settled else float(plan.duration), with_control_terms(context, plan, grid, u, bias)
    out, taps = context.buffer(x.size), control_taps(context, plan, u)
    defines = {**boundary_defines(plan.boundary), **cell_defines(plan, None), "CLOSED": ""}
    kernel = context.kernel("closed_form", "boundary closed stencil", defines)
    work = len(plan.template.control_taps) + (0 if settled else EXPONENTIALS)
    for first, lines in context.pieces(grid.lines, grid.cols * max(1, work)):
        parts = context.launch(
            kernel, lines * grid.cols, x, u, bias, mask, out, context.partial, number(plan.template.z),
            np.int32(bias is not None), np.int32(mask is not None), number(plan.template.self_feedback),
            number(0.0 if settled else t), np.int32(settled), np.int64(first), *taps, np.int64(lines),
            *grid.arguments[1:],
        )  # fmt: skip
        fine &= not context.parts(parts, context.dtype).any()  # NaN is not 0
    return Outcome(out, t, settled, 0.0 if settled else math.nan), fine
