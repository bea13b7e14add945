"""The closed form of cells without neighbours."""

import math

import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.backends.opencl.build import cell_defines
from cnnsim.backends.opencl.context import DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid, LinearPlanes
from cnnsim.backends.slices import EXPONENTIALS
from cnnsim.planning.plan import Plan


def closed_form(context: DeviceContext, plan: Plan, grid: DeviceGrid, planes: LinearPlanes) -> Outcome:
    """Return the end of uncoupled cells, at the plan's duration or at rest."""
    settled, number = plan.duration == "settled", context.dtype.type
    t = math.inf if settled else float(plan.duration)
    out = context.buffer(planes.x.size)
    kernel = context.kernel("closed_form", "closed", cell_defines(plan, None))
    for first, lines in context.pieces(grid.lines, grid.cols * (1 if settled else EXPONENTIALS)):
        context.launch(
            kernel, lines * grid.cols, *planes, out, number(plan.template.self_feedback),
            number(0.0 if settled else t), np.int32(settled), np.int32(planes.mask is not None), np.int64(first),
            np.int64(lines), np.int32(grid.cols),
        )  # fmt: skip
    return Outcome(out, t, settled, 0.0 if settled else math.nan)
