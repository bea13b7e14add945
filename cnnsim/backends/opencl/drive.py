"""What drives a cell without a time loop: w = B*u + z with the bias map and the terms of the input."""

from typing import Any

import numpy as np

from cnnsim.backends.opencl.device.build import boundary_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.term_tiles import TermTiles
from cnnsim.backends.term_table import tabulate
from cnnsim.network import Tap, reach
from cnnsim.planning.plan import Plan


def control(context: DeviceContext, plan: Plan, grid: DeviceGrid, u: Buffer | None, bias: Buffer | None) -> Buffer:
    """Return w = z + bias + terms of the input + B*u."""
    given, mapped = control_taps(context, plan, u), bias
    bias = with_control_terms(context, plan, grid, u, mapped)
    w = context.buffer(grid.cells * context.dtype.itemsize)
    kernel = context.kernel("control", "boundary stencil", {**boundary_defines(plan.boundary), "CONTROL": ""})
    for first, lines in context.pieces(grid.lines, grid.cols * max(1, len(plan.template.control_taps))):
        context.launch(
            kernel, lines * grid.cols, u, bias, w, context.dtype.type(plan.template.z), np.int32(bias is not None),
            np.int64(first), *given, np.int64(lines), *grid.arguments[1:],
        )  # fmt: skip
    if bias is not None and bias is not mapped:
        context.recycle(bias)
    return w


def control_taps(context: DeviceContext, plan: Plan, u: Buffer | None) -> tuple[Any, ...]:
    """Return what a kernel of stencil.cl is told of B; without an input there is nothing that it weighs."""
    return tap_arguments(context, plan.template.control_taps if u is not None else (), plan.boundary.u)


def with_control_terms(
    context: DeviceContext, plan: Plan, grid: DeviceGrid, u: Buffer | None, bias: Buffer | None
) -> Buffer | None:
    """Return the bias map plus all terms of the input alone, if there are any."""
    if u is None or not plan.template.control_terms:
        return bias
    table = tabulate(plan, [(0, term) for term in plan.template.control_terms], context.dtype)
    out = context.buffer(grid.cells * context.dtype.itemsize)
    TermTiles(context, plan, grid, table).drive([0.0], bias, out, lambda _: u)
    return out


def tap_arguments(context: DeviceContext, taps: tuple[Tap, ...], outside: float) -> tuple[Any, ...]:
    """Return what a kernel of stencil.cl is told of its taps and of virtual cells that hold a constant."""
    places = [(tap.k, tap.l) for tap in taps]
    weights = np.array([tap.weight for tap in taps] or [0.0], context.dtype)
    numbers = np.int32(len(taps)), np.int32(reach(places)), context.dtype.type(outside)
    return context.table(np.array(places or [(0, 0)], np.int32)), context.table(weights), *numbers
