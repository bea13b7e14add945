"""The drive of the input, w = B*u + z with the bias map, and the closed form of cells without neighbours."""

import math
from typing import Any

import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.backends.opencl.device.build import boundary_defines, cell_defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.network_planes import NetworkPlanes, NetworkTask, of_terms
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.slices import EXPONENTIALS
from cnnsim.backends.term_table import tabulate
from cnnsim.network import Tap, reach
from cnnsim.planning.plan import Plan


def control(context: DeviceContext, plan: Plan, grid: DeviceGrid, u: Buffer | None, bias: Buffer | None) -> Buffer:
    """Return w = z + bias + terms of the input + B*u."""
    taps, bias = _control_taps(context, plan, u), _with_control_terms(context, plan, grid, u, bias)
    w = context.plane(grid.cells)
    kernel = context.kernel("control", "boundary stencil", {**boundary_defines(plan.boundary), "CONTROL": ""})
    for first, lines in context.pieces(grid.lines, grid.cols * max(1, len(plan.template.control_taps))):
        context.launch(
            kernel, lines * grid.cols, u, bias, w, context.dtype.type(plan.template.z), np.int32(bias is not None),
            np.int64(first), *taps, np.int64(lines), *grid.arguments[1:],
        )  # fmt: skip
    return w


def closed_form(
    context: DeviceContext, plan: Plan, grid: DeviceGrid, x: Buffer, u: Any, bias: Any, mask: Buffer | None
) -> tuple[Outcome, bool]:
    """Return the end of uncoupled cells, at the plan's duration or at rest, and whether all states are finite."""
    settled, number, finite = plan.duration == "settled", context.dtype.type, True
    t = math.inf if settled else float(plan.duration)
    taps, bias = _control_taps(context, plan, u), _with_control_terms(context, plan, grid, u, bias)
    out = context.plane(grid.cells)
    defines = {**boundary_defines(plan.boundary), **cell_defines(plan, mask), "CLOSED": "", "REST": int(settled)}
    kernel = context.kernel("closed_form", "boundary closed stencil", defines)
    work = len(plan.template.control_taps) + (0 if settled else EXPONENTIALS)
    for first, lines in context.pieces(grid.lines, grid.cols * max(1, work)):
        parts = context.launch(
            kernel, lines * grid.cols, x, u, bias, mask, out, context.partial, number(plan.template.z),
            np.int32(bias is not None), number(plan.template.self_feedback), number(0.0 if settled else t),
            np.int64(first), *taps, np.int64(lines), *grid.arguments[1:],
        )  # fmt: skip
        finite &= not context.parts(parts, context.dtype).any()  # NaN is not 0
    return Outcome(out, t, settled, 0.0 if settled else math.nan), finite


def tap_arguments(context: DeviceContext, taps: tuple[Tap, ...], outside: float) -> tuple[Any, ...]:
    """Return the arguments of a kernel of stencil.cl for its taps, and the value of fixed virtual cells."""
    places = [(tap.k, tap.l) for tap in taps]
    weights = np.array([tap.weight for tap in taps] or [0.0], context.dtype)
    numbers = np.int32(len(taps)), np.int32(reach(places)), context.dtype.type(outside)
    return context.table(np.array(places or [(0, 0)], np.int32)), context.table(weights), *numbers


def _control_taps(context: DeviceContext, plan: Plan, u: Buffer | None) -> tuple[Any, ...]:
    return tap_arguments(context, plan.template.control_taps if u is not None else (), plan.boundary.u)


def _with_control_terms(
    context: DeviceContext, plan: Plan, grid: DeviceGrid, u: Buffer | None, bias: Buffer | None
) -> Buffer | None:
    """Return the bias map plus all terms of the input."""
    if u is None or not plan.template.control_terms:
        return bias
    table = tabulate(plan, [(0, term) for term in plan.template.control_terms], context.dtype)
    planes, out = NetworkPlanes(context, plan, grid, table.radius, delay=None, inputs=1), context.plane(grid.cells)
    planes.padded.pad(u, planes.u, 0, plan.boundary.u)
    planes.set_bias(bias)
    planes.do(NetworkTask.DRIVE, of_terms(context, plan, table, [0], output=False))
    planes.padded.unpad(planes.w, 0, out)
    return out
