"""The OpenCL backend: planes are on a device, transients run there, only numbers and results are transferred back.

From `OpenCLBackend.transient` to the launch of a kernel: `driver.run`, ``advance`` in linear_steps.py (linear
templates, one-stage schemes) or network_steps.py (all others), and `DeviceContext.enqueue`.
"""

from collections.abc import Callable, Sequence
from typing import Any
from weakref import finalize

import numpy as np
import pyopencl as cl
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends import driver
from cnnsim.backends.base import (
    Backend,
    Memory,
    Outcome,
    check_finite,
    check_fixed_step,
    parse_dtype,
)
from cnnsim.backends.opencl.control import closed_form, control
from cnnsim.backends.opencl.device.build import boundary_defines
from cnnsim.backends.opencl.device.context import device_context
from cnnsim.backends.opencl.device.devices import Family, choose_device, family_of, has_float64, title
from cnnsim.backends.opencl.linear_steps import DeviceLinearSteps
from cnnsim.backends.opencl.network_steps import DeviceDiscreteSteps, LinearStageSteps, NetworkSteps
from cnnsim.backends.opencl.patch_steps import PatchSteps
from cnnsim.backends.opencl.planes import (
    WORD,
    DevicePlane,
    LinearPlanes,
    buffers,
    cellwise_text,
    launch,
    new_plane,
    words_of,
)
from cnnsim.backends.opencl.routine import DeviceRoutine, fits
from cnnsim.network import Boundary, Characteristic
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.routine import Routine, Stores
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError


class OpenCLBackend(Backend):
    """Computes on one OpenCL device, in float32 or float64; one thread at a time launches (see `DeviceContext`).

    Arguments: ``device`` as in `choose_device`; ``family`` of kernels, None for the device's own.

    Raises:
        InputError: no such device, or one that has no float64 where that is wanted.
    """

    name = "opencl"
    fuses = True

    def __init__(
        self, dtype: DTypeLike | None = None, device: int | str | None = None, family: Family | None = None
    ) -> None:
        self.dtype = parse_dtype(np.float32 if dtype is None else dtype)
        if self.dtype not in (np.float32, np.float64):
            raise InputError(f"the opencl backend computes in float32 or float64, not in {self.dtype}")
        self.device, self.chosen_device = choose_device(device), None if device is None else str(device)
        if self.dtype == np.float64 and not has_float64(self.device):
            raise InputError(f"{title(self.device)} has no float64; use float32, or another device")
        self._family = family
        self._context = device_context(self.device, family or family_of(self.device), self.dtype)

    def __reduce__(self) -> Any:
        """Go to another process as the choices that were made; the device is looked for again there."""
        return OpenCLBackend, (self.dtype, self.chosen_device, self._family)

    def load(self, values: Array, memory: Memory, *, copy: bool = True) -> DevicePlane:
        values = np.asarray(values)
        if memory == "lam":
            host: Array = np.ascontiguousarray(values, dtype=self.dtype)
        else:
            host = np.zeros((*values.shape[:-1], words_of(values.shape[-1]) * 8), np.uint8)
            packed = np.packbits(values > 0, axis=-1, bitorder="little")
            host[..., : packed.shape[-1]] = packed
        in_place = not copy and memory == "lam" and self._context.works_in_place(host.nbytes)
        kept, copied = cl.mem_flags.READ_ONLY | cl.mem_flags.USE_HOST_PTR, cl.mem_flags.READ_WRITE
        flags = kept if in_place else copied | cl.mem_flags.COPY_HOST_PTR
        buffer = self._context.load(host, flags)
        return DevicePlane(buffer, values.shape, memory, callers=in_place)

    def read(self, plane: DevicePlane, *, copy: bool = True) -> Array:
        words = plane.memory == "llm"
        if not (copy or words or plane.callers) and self._context.works_in_place(plane.buffer.size):
            queue, write = self._context.queue, cl.map_flags.WRITE
            array: Array = cl.enqueue_map_buffer(queue, plane.buffer, write, 0, plane.shape, self.dtype)[0]
            finalize(array, id, plane.buffer).atexit = False  # its memory is in use as long as the array
            return array
        row = words_of(plane.shape[-1]) * 8 if words else plane.shape[-1]
        host = plane.host
        if host is None:
            host = self._context.read(
                plane.buffer, np.empty((*plane.shape[:-1], row), np.uint8 if words else self.dtype)
            )
        elif not words:
            host = host.copy()
        return np.unpackbits(host, axis=-1, count=plane.shape[-1], bitorder="little").astype(bool) if words else host

    def convert(self, plane: DevicePlane, memory: Memory) -> DevicePlane:
        if plane.memory == memory:
            return plane
        with self._context.lock:
            out, size = new_plane(self._context, plane.shape, memory), plane.grid.flat_arguments
            launch(self._context, f"to_{memory}", plane.words * WORD, plane.buffer, out.buffer, *size)
            return out

    def output(self, x: DevicePlane, f: Characteristic = CLIP) -> DevicePlane:
        if f != CLIP:  # seldom: no kernel of its own
            return self.load(f(self.read(x)), "lam")
        with self._context.lock:
            y, cells = new_plane(self._context, x.shape, "lam"), x.grid.cells
            launch(self._context, "clipped", cells, x.buffer, y.buffer, np.int64(cells))
            return y

    def transient(
        self, plan: Plan, x: DevicePlane, u: Any, bias: Any = None, mask: DevicePlane | None = None
    ) -> Outcome:
        check_fixed_step(plan)
        context, grid = self._context, x.grid
        with context.lock:
            u, bias, black = buffers(u), buffers(bias), buffers(mask)
            if plan.method == "general":
                kind = DeviceDiscreteSteps if plan.cell == "discrete-time" else NetworkSteps
                network = kind(context, plan, grid, x.buffer, u, bias, black)
                outcome = driver.run(plan, network, network.spans())
            elif plan.method == "closed form":
                outcome, fine = closed_form(context, plan, grid, x.buffer, u, bias, black)
            else:
                assert plan.scheme is not None
                planes = LinearPlanes(x.buffer, control(context, plan, grid, u, bias), black)
                if len(plan.scheme.b) > 1:
                    outcome = driver.run(plan, LinearStageSteps(context, plan, grid, planes))
                elif context.family == "cpu":
                    outcome = driver.run(plan, DeviceLinearSteps(context, plan, grid, planes))
                else:
                    outcome = driver.run_with_checks(plan, PatchSteps(context, plan, grid, planes))
            state = x if outcome.x is x.buffer else DevicePlane(outcome.x, x.shape, "lam")  # no step was taken, or some
            if plan.method != "closed form":
                parts = launch(context, "finite", grid.cells, state.buffer, context.partial, np.int64(grid.cells))
                fine = not context.parts(parts, context.dtype).any()
            if not fine:
                check_finite(self.read(state), outcome.t)
            return outcome._replace(x=state)

    def cellwise(
        self, operation: Cellwise, planes: Sequence[DevicePlane], parameters: Sequence[float]
    ) -> tuple[DevicePlane, ...]:
        with self._context.lock:
            kernel = self._context.kernel("cellwise", "", {}, extra=cellwise_text(operation))
            outputs = tuple(new_plane(self._context, planes[0].shape, "lam") for _ in operation.outputs)
            given = [plane.buffer for plane in (*planes, *outputs)]
            cells, number = planes[0].grid.cells, self._context.dtype.type
            self._context.launch(kernel, cells, *given, *map(number, parameters), np.int64(cells))
            return outputs

    def logic(self, function: int, p: DevicePlane, q: DevicePlane) -> DevicePlane:
        with self._context.lock:
            out, size = new_plane(self._context, p.shape, "llm"), p.grid.flat_arguments
            launch(self._context, "logic", p.words, p.buffer, q.buffer, out.buffer, np.int32(function), *size)
            return out

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: DevicePlane) -> DevicePlane:
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
        context, words = self._context, plane.words
        with context.lock:
            if len(plane.shape) == 3:
                grids = plane.shape[0]
                totals, each = np.empty(grids, np.int64), context.buffer(8 * grids)
                launch(context, "count_each", words, plane.buffer, each, np.int64(grids), np.int32(words // grids))
                context.read(each, totals)
                return totals
            parts = launch(context, "count_black", words, plane.buffer, context.partial, np.int64(words))
            return int(context.parts(parts, np.dtype(np.uint64)).sum())

    def prepared(self, routine: Routine) -> Callable[[Stores], Stores | None] | None:
        if not fits(routine, self._context.family):
            return None
        compiled = DeviceRoutine(self._context, routine)
        return compiled if compiled.fits else None


BACKEND = OpenCLBackend
