"""The OpenCL backend: planes live on a device, transients run there, only numbers and results come back."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

import numpy as np
import pyopencl as cl
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends.base import Memory, Outcome, check_finite
from cnnsim.backends.opencl.build import boundary_defines, workshop
from cnnsim.backends.opencl.cellwise import parameter_values, text
from cnnsim.backends.opencl.device import Family, choose_device, family_of, has_float64, title
from cnnsim.backends.opencl.terms import control_terms, general
from cnnsim.backends.opencl.transient import closed_form, drive, stepped
from cnnsim.network.boundary import Boundary
from cnnsim.network.frames import Frames
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.planning.plan import Plan
from cnnsim.support.errors import InputError
from cnnsim.support.types import Array

P = ParamSpec("P")
T = TypeVar("T")
_WORD = 64  # cells of an LLM plane in a word


@dataclass(frozen=True)
class DevicePlane:
    """A plane on the device: numbers (LAM), or bits in 64-bit words, a row beginning a new word (LLM)."""

    buffer: cl.Buffer
    shape: tuple[int, ...]
    memory: Memory

    @property
    def grids(self) -> tuple[int, int, int]:
        """The shape as a batch: (n, rows, cols)."""
        return (math.prod(self.shape[:-2]), *cast(tuple[int, int], self.shape[-2:]))

    @property
    def lines(self) -> int:
        """Rows of all grids."""
        return math.prod(self.shape[:-1])

    @property
    def words(self) -> int:
        """Words of an LLM plane."""
        return self.lines * -(-self.shape[-1] // _WORD)

    @property
    def cells(self) -> int:
        """Cells of all grids."""
        return math.prod(self.shape)


def _alone(verb: Callable[Concatenate["OpenCLBackend", P], T]) -> Callable[Concatenate["OpenCLBackend", P], T]:
    """Let one thread at a time launch kernels; see `Workshop`."""

    @wraps(verb)
    def locked(self: "OpenCLBackend", /, *args: P.args, **kwargs: P.kwargs) -> T:
        with self._shop.lock:
            return verb(self, *args, **kwargs)

    return locked


class OpenCLBackend:
    """Computes on one OpenCL device, in float32 or float64.

    Arguments: ``device`` as in `opencl_device.choose_device`; ``family`` of kernels, None for the device's own.

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
        self._shop = workshop(self.device, family or family_of(self.device), self.dtype)

    def load(self, values: Array, memory: Memory) -> DevicePlane:
        """See `Backend.load`."""
        values = np.asarray(values)
        if memory == "lam":
            host: Array = np.ascontiguousarray(values, dtype=self.dtype)
        else:
            host = np.zeros((*values.shape[:-1], -(-values.shape[-1] // _WORD) * _WORD // 8), np.uint8)
            packed = np.packbits(values > 0, axis=-1, bitorder="little")
            host[..., : packed.shape[-1]] = packed
        flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
        return DevicePlane(cl.Buffer(self._shop.context, flags, hostbuf=host), values.shape, memory)

    def read(self, plane: DevicePlane) -> Array:
        """See `Backend.read`."""
        if plane.memory == "lam":
            numbers = np.empty(plane.shape, self.dtype)
            cl.enqueue_copy(self._shop.queue, numbers, plane.buffer)
            return numbers
        words = np.empty((*plane.shape[:-1], plane.words // plane.lines * 8), np.uint8)
        cl.enqueue_copy(self._shop.queue, words, plane.buffer)
        return np.unpackbits(words, axis=-1, count=plane.shape[-1], bitorder="little").astype(bool)

    @_alone
    def convert(self, plane: DevicePlane, memory: Memory) -> DevicePlane:
        """See `Backend.convert`."""
        if plane.memory == memory:
            return plane
        out = self._new(plane.shape, memory)
        self._run(f"to_{memory}", plane.words * _WORD, plane.buffer, out.buffer, *self._lines(plane))
        return out

    @_alone
    def output(self, x: DevicePlane) -> DevicePlane:
        """See `Backend.output`."""
        y = self._new(x.shape, "lam")
        self._run("clipped", x.cells, x.buffer, y.buffer, np.int64(x.cells))
        return y

    @_alone
    def transient(
        self,
        plan: Plan,
        x: DevicePlane,
        u: DevicePlane | None,
        bias: DevicePlane | None = None,
        mask: DevicePlane | None = None,
    ) -> Outcome:
        """See `Backend.transient`."""
        _check_plan(plan)
        shop, shape = self._shop, x.grids
        held = None if mask is None else mask.buffer
        if plan.method == "general":
            buffers = (_buffers(u), _buffers(bias), held)
            end, t, settled, slope = general(shop, plan, shape[0], x.buffer, *buffers)
            state = DevicePlane(end, x.shape, "lam")
            self._check_finite(state, t)
            return Outcome(state, t, settled, slope)
        if u is not None and plan.template.control_terms:
            heard = control_terms(shop, plan, shape[0], u.buffer, _buffers(bias))
            bias = DevicePlane(heard, x.shape, "lam")
        w = drive(shop, plan, shape, None if u is None else u.buffer, None if bias is None else bias.buffer)
        settle = plan.duration == "settled"
        if plan.method == "closed form":
            end = closed_form(shop, plan, shape, x.buffer, w, held)
            t, settled, slope = (math.inf, True, 0.0) if settle else (float(plan.duration), False, math.nan)
        else:
            end, done, settled, slope = stepped(shop, plan, shape, x.buffer, w, held)
            t = done * plan.step if settle else float(plan.duration)
        shop.recycle(w)
        state = DevicePlane(end, x.shape, "lam")
        self._check_finite(state, t)
        return Outcome(state, t, settled, slope)

    @_alone
    def cellwise(
        self, operation: Cellwise, planes: Sequence[DevicePlane], parameters: Sequence[float]
    ) -> tuple[DevicePlane, ...]:
        """See `Backend.cellwise`."""
        kernel = self._shop.kernel("cellwise", "", {}, extra=text(operation))
        outputs = tuple(self._new(planes[0].shape, "lam") for _ in operation.outputs)
        buffers = [plane.buffer for plane in (*planes, *outputs)]
        cells = planes[0].cells
        self._shop.run(kernel, cells, *buffers, *parameter_values(parameters, self.dtype), np.int64(cells))
        return outputs

    @_alone
    def logic(self, function: int, p: DevicePlane, q: DevicePlane) -> DevicePlane:
        """See `Backend.logic`."""
        out = self._new(p.shape, "llm")
        self._run("logic", p.words, p.buffer, q.buffer, out.buffer, np.int32(function), *self._lines(p))
        return out

    @_alone
    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: DevicePlane) -> DevicePlane:
        """See `Backend.neighbourhood`."""
        out = self._new(plane.shape, "llm")
        literals = self._shop.table(np.array(rule.literals or [(0, 0, 0)], np.int32))
        self._shop.run(
            self._shop.kernel("neighbourhood", "neighbourhood", boundary_defines(boundary)), plane.words, plane.buffer,
            out.buffer, literals, np.int32(len(rule.literals)), np.int32(rule.conjunction), np.int32(boundary.u > 0),
            np.int32(rule.radius), np.int64(plane.lines), np.int32(plane.shape[-2]), np.int32(plane.shape[-1]),
        )  # fmt: skip
        return out

    @_alone
    def count(self, plane: DevicePlane) -> int | NDArray[np.int64]:
        """See `Backend.count`."""
        if len(plane.shape) == 3:
            grids = plane.shape[0]
            totals, each = np.empty(grids, np.int64), self._shop.buffer(8 * grids)
            self._run("count_each", plane.words, plane.buffer, each, np.int64(grids), np.int32(plane.words // grids))
            cl.enqueue_copy(self._shop.queue, totals, each)
            return totals
        parts = self._run("count_black", plane.words, plane.buffer, self._shop.partial, np.int64(plane.words))
        return int(self._shop.parts(parts, np.dtype(np.uint64)).sum())

    def _check_finite(self, x: DevicePlane, t: float) -> None:
        parts = self._run("finite", x.cells, x.buffer, self._shop.partial, np.int64(x.cells))
        if self._shop.parts(parts, self.dtype).any():
            check_finite(self.read(x), t)

    def _new(self, shape: tuple[int, ...], memory: Memory) -> DevicePlane:
        row = shape[-1] * self.dtype.itemsize if memory == "lam" else -(-shape[-1] // _WORD) * 8
        return DevicePlane(self._shop.buffer(math.prod(shape[:-1]) * row), shape, memory)

    def _run(self, name: str, work: int, *arguments: Any) -> int:
        return self._shop.run(self._shop.kernel(name, "planes", {}), work, *arguments)

    @staticmethod
    def _lines(plane: DevicePlane) -> tuple[np.int64, np.int32]:
        return np.int64(plane.lines), np.int32(plane.shape[-1])


def _check_plan(plan: Plan) -> None:
    """Refuse what has no OpenCL kernel, rather than leave a part of it out."""
    if plan.method == "adaptive" or (plan.method == "general" and plan.cell != "discrete-time" and plan.scheme is None):
        raise InputError(
            "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
        )


def _buffers(value: DevicePlane | Frames[DevicePlane] | None) -> Any:
    """Return what a plane, or each plane of a sequence, is on the device."""
    if isinstance(value, Frames):
        return value.map(lambda plane: plane.buffer)
    return None if value is None else value.buffer


BACKEND = OpenCLBackend
