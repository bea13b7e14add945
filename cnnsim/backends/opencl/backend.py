"""The OpenCL backend: planes live on a device, transients run there, only numbers and results come back."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends import driver
from cnnsim.backends.base import Memory, Outcome, check_finite
from cnnsim.backends.opencl import planes, pocl
from cnnsim.backends.opencl.build import boundary_defines
from cnnsim.backends.opencl.cellwise import text
from cnnsim.backends.opencl.closed import closed_form
from cnnsim.backends.opencl.context import device_context
from cnnsim.backends.opencl.devices import Family, choose_device, family_of, has_float64, title
from cnnsim.backends.opencl.drive import control
from cnnsim.backends.opencl.planes import DevicePlane, LinearPlanes, buffers, launch, new_plane
from cnnsim.backends.opencl.term_steps import term_steps
from cnnsim.backends.opencl.transient import linear_steps
from cnnsim.network import Boundary
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError


class OpenCLBackend:
    """Computes on one OpenCL device, in float32 or float64; one thread at a time launches (see `DeviceContext`).

    Arguments: ``device`` as in `choose_device`; ``family`` of kernels, None for the device's own.

    Raises:
        InputError: no such device, or one that has no float64 where that is wanted.
    """

    name = "opencl"

    def __init__(
        self, dtype: DTypeLike | None = None, device: int | str | None = None, family: Family | None = None
    ) -> None:
        self.dtype = np.dtype(np.float32 if dtype is None else dtype)
        if self.dtype not in (np.float32, np.float64):
            raise InputError(f"the opencl backend computes in float32 or float64, not in {self.dtype}")
        self.device = choose_device(device)
        if self.dtype == np.float64 and not has_float64(self.device):
            raise InputError(f"{title(self.device)} has no float64; use float32, or another device")
        pocl.name_processor(self.device)
        self._context = device_context(self.device, family or family_of(self.device), self.dtype)

    def load(self, values: Array, memory: Memory) -> DevicePlane:
        """See `Backend.load`."""
        return planes.load(self._context, np.asarray(values), memory)

    def read(self, plane: DevicePlane) -> Array:
        """See `Backend.read`."""
        return planes.read(self._context, plane)

    def convert(self, plane: DevicePlane, memory: Memory) -> DevicePlane:
        """See `Backend.convert`."""
        if plane.memory == memory:
            return plane
        with self._context.lock:
            return planes.convert(self._context, plane, memory)

    def output(self, x: DevicePlane) -> DevicePlane:
        """See `Backend.output`."""
        with self._context.lock:
            y, cells = new_plane(self._context, x.shape, "lam"), x.grid.cells
            launch(self._context, "clipped", cells, x.buffer, y.buffer, np.int64(cells))
            return y

    def transient(
        self, plan: Plan, x: DevicePlane, u: Any, bias: Any = None, mask: DevicePlane | None = None
    ) -> Outcome:
        """See `Backend.transient`."""
        _check_plan(plan)
        context, grid = self._context, x.grid
        with context.lock:
            u, bias, black = buffers(u), buffers(bias), buffers(mask)
            if plan.method == "general":
                steps = term_steps(context, plan, grid, x.buffer, u, bias, black)
                outcome = driver.run(plan, steps, steps.spans())
            else:
                w = control(context, plan, grid, u, bias)
                given = LinearPlanes(x.buffer, w, black)
                if plan.method == "closed form":
                    outcome = closed_form(context, plan, grid, given)
                else:
                    outcome = driver.run(plan, linear_steps(context, plan, grid, given))
                context.recycle(w)
            state = DevicePlane(outcome.x, x.shape, "lam")
            if not planes.all_finite(context, state):
                check_finite(self.read(state), outcome.t)
            return outcome._replace(x=state)

    def cellwise(
        self, operation: Cellwise, planes: Sequence[DevicePlane], parameters: Sequence[float]
    ) -> tuple[DevicePlane, ...]:
        """See `Backend.cellwise`."""
        with self._context.lock:
            kernel = self._context.kernel("cellwise", "", {}, extra=text(operation))
            outputs = tuple(new_plane(self._context, planes[0].shape, "lam") for _ in operation.outputs)
            given = [plane.buffer for plane in (*planes, *outputs)]
            cells, number = planes[0].grid.cells, self._context.dtype.type
            self._context.launch(kernel, cells, *given, *map(number, parameters), np.int64(cells))
            return outputs

    def logic(self, function: int, p: DevicePlane, q: DevicePlane) -> DevicePlane:
        """See `Backend.logic`."""
        with self._context.lock:
            out, size = new_plane(self._context, p.shape, "llm"), p.grid.flat_arguments
            launch(self._context, "logic", p.words, p.buffer, q.buffer, out.buffer, np.int32(function), *size)
            return out

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: DevicePlane) -> DevicePlane:
        """See `Backend.neighbourhood`."""
        with self._context.lock:
            out = new_plane(self._context, plane.shape, "llm")
            literals = self._context.table(np.array(rule.literals or [(0, 0, 0)], np.int32))
            self._context.launch(
                self._context.kernel("neighbourhood", "boundary neighbourhood", boundary_defines(boundary)),
                plane.words, plane.buffer, out.buffer, literals, np.int32(len(rule.literals)),
                np.int32(rule.conjunction), np.int32(boundary.u > 0), np.int32(rule.radius),
                *plane.grid.arguments,
            )  # fmt: skip
            return out

    def count(self, plane: DevicePlane) -> int | NDArray[np.int64]:
        """See `Backend.count`."""
        with self._context.lock:
            return planes.count(self._context, plane)


def _check_plan(plan: Plan) -> None:
    """Refuse what has no OpenCL kernel, rather than leave a part of it out."""
    if plan.method == "adaptive" or (plan.method == "general" and plan.cell != "discrete-time" and plan.scheme is None):
        raise InputError(
            "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
        )


BACKEND = OpenCLBackend
