"""The CPU backend: numba loops over whole transients, float32 or float64, on all cores."""

import math
from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numba
import numpy as np
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends.base import Memory, Outcome, check_finite
from cnnsim.backends.cpu import bits as cpu_bits
from cnnsim.backends.cpu import closed as cpu_closed
from cnnsim.backends.cpu import kernels as cpu_kernels
from cnnsim.backends.cpu import terms as cpu_general
from cnnsim.backends.cpu.bits import Bits
from cnnsim.backends.cpu.drive import control, controlling
from cnnsim.backends.cpu.euler.dense import dense
from cnnsim.backends.cpu.euler.sleep import sleeping
from cnnsim.backends.cpu.jit.compile import THREADS_PAY_FROM, Kernel, kept_in
from cnnsim.backends.cpu.neighbourhood import neighbourhood
from cnnsim.backends.cpu.pool import Spare
from cnnsim.backends.cpu.prepared import Prepared
from cnnsim.network import Boundary
from cnnsim.network.boundary import virtual_index
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError
from cnnsim.support.compile_notice import announce

announce(kept_in(cpu_kernels.clip.serial))

_NO_MASK = np.empty((1, 1, 0), dtype=bool)


def _grids(plane: Array) -> Array:
    """View (rows, cols) as one grid of a batch, and the layers of a batch as grids."""
    return plane if plane.ndim == 3 else plane.reshape(-1, *plane.shape[-2:])


class CpuBackend:
    """LAM planes are contiguous NumPy arrays in ``dtype``, LLM planes are `Bits`."""

    name = "cpu"

    def __init__(self, dtype: DTypeLike | None = None) -> None:
        self.dtype = np.dtype(np.float32 if dtype is None else dtype)
        if self.dtype not in (np.float32, np.float64):
            raise InputError(f"the cpu backend computes in float32 or float64, not in {self.dtype}")
        self._prepared: WeakKeyDictionary[Plan, Prepared] = WeakKeyDictionary()
        self._rules: dict[tuple[BitRule, Boundary, tuple[int, ...]], tuple[Any, ...]] = {}
        self._kernels: dict[str, Kernel] = {}
        self._spare = Spare()
        self._nothing = np.empty((1, 1, 0), self.dtype)
        self._one, self._minus_one = self.dtype.type(1), self.dtype.type(-1)

    def load(self, values: Array, memory: Memory) -> Any:
        """See `Backend.load`."""
        if memory == "llm":
            return self._pack(np.ascontiguousarray(values))
        return np.array(values, dtype=self.dtype, order="C")

    def read(self, plane: Any) -> Array:
        """See `Backend.read`."""
        return self._unpack(plane, np.dtype(bool)) if isinstance(plane, Bits) else plane.copy()

    def convert(self, plane: Any, memory: Memory) -> Any:
        """See `Backend.convert`."""
        return self._pack(plane) if memory == "llm" else self._unpack(plane, self.dtype)

    def _pack(self, values: Array) -> Bits:
        bits = cpu_bits.empty(values.shape)
        cpu_bits.pack.for_work(values.size)(_grids(values), bits.words)
        return bits

    def _unpack(self, bits: Bits, dtype: np.dtype[Any]) -> Array:
        values = np.empty(bits.shape, dtype)
        black, white = (self._one, self._minus_one) if dtype == self.dtype else (np.True_, np.False_)
        cpu_bits.unpack.for_work(values.size)(bits.words, _grids(values), black, white)
        return values

    def output(self, x: Array) -> Array:
        """See `Backend.output`."""
        y = np.empty_like(x)
        cpu_kernels.clip.for_work(x.size)(_grids(x), _grids(y))
        return y

    def transient(
        self, plan: Plan, x: Array, u: Array | None, bias: Array | None = None, mask: Bits | None = None
    ) -> Outcome:
        """See `Backend.transient`."""
        if plan.method == "general":
            return cpu_general.transient(plan, x, u, bias, None if mask is None else self._unpack(mask, np.dtype(bool)))
        bias = cpu_general.with_control_terms(plan, u, bias)
        ready = self._prepared.get(plan)
        if ready is None:
            ready = self._prepared[plan] = Prepared(plan, self.dtype, numba.get_num_threads())
        free = _NO_MASK if mask is None else _grids(self._unpack(mask, np.dtype(bool)))
        drive = (
            ready.z, self._nothing if bias is None else _grids(bias), _grids(x if u is None else u),
            *ready.control, *ready.around_u,
        )  # fmt: skip
        work = x.size * max(1, ready.control[0].size)
        if plan.method == "closed form":
            end = np.empty_like(x)
            cpu_closed.closed_form.for_work(work)(_grids(x), _grids(end), free, ready.a, ready.t, ready.walls, *drive)
            outcome = Outcome(end, ready.t, ready.settles, 0.0 if ready.settles else math.nan)
        elif plan.method == "stepped":
            w = self._spare.plane(x)
            control.for_work(work)(controlling(self.dtype).address, _grids(w), *drive)
            outcome = self._stepped(plan, ready, x, w, free)
            self._spare.keep(w)
        else:
            raise InputError(
                "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
            )
        if not cpu_kernels.all_finite.for_work(x.size)(_grids(outcome.x)):
            check_finite(outcome.x, outcome.t)
        return outcome

    def _stepped(self, plan: Plan, ready: Prepared, x: Array, w: Array, mask: Array) -> Outcome:
        work = x.size * len(plan.feedback_taps)
        if len(ready.hb) == 1 and not mask.size and not ready.walls:
            threads = numba.get_num_threads() if work >= THREADS_PAY_FROM else 1
            planes = x, self._spare.plane(x), self._spare.plane(x)
            given = (*map(_grids, planes), _grids(w), ready.rule, plan.depth)
            if "sleep" in plan.savings:
                done, settled, slope, where = sleeping.for_work(work)(*given, ready.tile_at, threads, *ready.steps[:3])
            else:
                done, settled, slope, where = dense.for_work(work)(
                    *given, ready.tile_at, *ready.tile, threads, *ready.steps
                )
            end = x.copy() if where == 0 else planes[where]
            self._spare.keep(*(plane for plane in planes[1:] if plane is not end))
        else:
            end = x.copy()
            done, settled, slope = cpu_kernels.stepped.for_work(work)(
                _grids(end), _grids(w), mask, *ready.feedback, *ready.around_y, ready.ha, ready.hb, *ready.steps,
                ready.walls,
            )  # fmt: skip
        return Outcome(end, done * plan.step if ready.settles else ready.t, bool(settled), float(slope))

    def cellwise(self, operation: Cellwise, planes: Sequence[Array], parameters: Sequence[float]) -> tuple[Array, ...]:
        """See `Backend.cellwise`."""
        if operation.compiled is None:
            return operation.array(*planes, *parameters)
        if operation.name not in self._kernels:
            self._kernels[operation.name] = operation.compiled()
        outputs = tuple(np.empty_like(planes[0]) for _ in operation.outputs)
        flat = [plane.reshape(-1) for plane in (*planes, *outputs)]
        self._kernels[operation.name](*flat, *parameters)
        return outputs

    def logic(self, function: int, p: Bits, q: Bits) -> Bits:
        """See `Backend.logic`."""
        out = cpu_bits.empty(p.shape)
        cpu_bits.logic.for_work(out.words.size // 64)(function, p.words, q.words, out.words, p.shape[-1])
        return out

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Bits) -> Bits:
        """See `Backend.neighbourhood`."""
        key = rule, boundary, plane.shape[-2:]
        if key not in self._rules:
            k, l, negated = (np.array([literal[i] for literal in rule.literals], np.int64) for i in range(3))
            rows, cols = (virtual_index(n, rule.radius, boundary) for n in plane.shape[-2:])
            self._rules[key] = k, l, negated > 0, rule.conjunction, rows, cols, rule.radius, int(boundary.u > 0)
        out = cpu_bits.empty(plane.shape)
        kernel = neighbourhood.for_work(out.words.size * len(rule.literals) // 64)
        kernel(plane.words, out.words, plane.shape[-1], *self._rules[key])
        return out

    def count(self, plane: Bits) -> int | NDArray[np.int64]:
        """See `Backend.count`."""
        totals = np.empty(plane.words.shape[0], np.int64)
        cpu_bits.count.for_work(plane.words.size // 64)(plane.words, totals)
        return totals if len(plane.shape) == 3 else int(totals[0])


BACKEND = CpuBackend
