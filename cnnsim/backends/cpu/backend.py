"""The CPU backend: numba loops over whole transients, float32 or float64, on all cores."""

import math
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numba
import numpy as np
from numpy.typing import DTypeLike

from cnnsim.backends import driver
from cnnsim.backends.base import (
    Backend,
    Memory,
    Outcome,
    check_finite,
    check_fixed_step,
    parse_dtype,
)
from cnnsim.backends.cpu import bits as packed
from cnnsim.backends.cpu import closed, planes
from cnnsim.backends.cpu.bits import Bits
from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.compiled import Kernel, cache_folder, tap_records
from cnnsim.backends.cpu.drive import control
from cnnsim.backends.cpu.neighbourhood import literals, neighbourhood
from cnnsim.backends.cpu.planes import Pool, grids
from cnnsim.backends.cpu.routine import MOST_CELLS, CompiledRoutine
from cnnsim.backends.cpu.threads import checked_threads, keep_to
from cnnsim.backends.cpu.tiles.euler import EulerTiles
from cnnsim.backends.cpu.tiles.network import DiscreteSteps, Network, TermNetwork, TermSteps, with_control_terms
from cnnsim.backends.slices import EXPONENTIALS, pieces
from cnnsim.network import Boundary, Characteristic, reach
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.routine import Routine, Stores
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError, Integers
from cnnsim.support.notices import announce

announce(cache_folder(planes.clip.serial))

_NO_MASK = np.empty((1, 1, 0), dtype=bool)


class Prepared:
    """Taps, virtual cells and numbers of one plan, in one dtype, for one number of threads."""

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        template, boundary = plan.template, plan.boundary
        self.control = tap_records(template.control_taps, dtype)
        r = reach((tap.k, tap.l) for tap in template.control_taps)
        self.around_u = virtual_cells(plan.shape, r, boundary, dtype.type(boundary.u))
        self.z = dtype.type(template.z)
        self.settles, limited = plan.duration == "settled", plan.cell == "full-range"
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        a = dtype.type(template.self_feedback) if self.settles else float(template.self_feedback)
        self.cell = a, self.t, limited
        self.fuses = plan.scheme is not None and len(plan.scheme.b) == 1 and not limited
        self._dtype, self._threads = dtype, threads
        self._euler: EulerTiles | None = None

    def euler(self, plan: Plan) -> EulerTiles:
        """Return the Euler steps by tiles. The plan is not kept, so that its constants go with it."""
        if self._euler is None:
            self._euler = EulerTiles(plan, self._dtype, self._threads)
        return self._euler


class CpuBackend(Backend):
    """LAM planes are contiguous NumPy arrays in ``dtype``, LLM planes are `Bits`.

    ``threads`` share the work of a large grid, None for all cores; a small grid takes one (see `THREADS_PAY_FROM`).
    """

    name = "cpu"

    def __init__(self, dtype: DTypeLike | None = None, threads: int | None = None) -> None:
        self.dtype = parse_dtype(np.float32 if dtype is None else dtype)
        if self.dtype not in (np.float32, np.float64):
            raise InputError(f"the cpu backend computes in float32 or float64, not in {self.dtype}")
        self._prepared: WeakKeyDictionary[Plan, Prepared] = WeakKeyDictionary()
        self._rules: dict[tuple[BitRule, Boundary, tuple[int, ...]], tuple[Any, ...]] = {}
        self._kernels: dict[str, Kernel] = {}
        self._pool = Pool()
        self._nothing = np.empty((1, 1, 0), self.dtype)
        self._one, self._minus_one = self.dtype.type(1), self.dtype.type(-1)
        self._threads = threads
        if threads is not None:
            keep_to(self, checked_threads(threads))

    def __reduce__(self) -> Any:
        """Pickle the arguments of the constructor."""
        return CpuBackend, (self.dtype, self._threads)

    def load(self, values: Array, memory: Memory, *, copy: bool = True) -> Any:
        if memory == "llm":
            return self._pack(np.ascontiguousarray(values))
        return np.array(values, self.dtype, order="C") if copy else np.ascontiguousarray(values, self.dtype)

    def read(self, plane: Any, *, copy: bool = True) -> Array:
        if isinstance(plane, Bits):
            return self._unpack(plane, np.dtype(bool))
        return plane.copy() if copy else plane

    def convert(self, plane: Any, memory: Memory) -> Any:
        return self._pack(plane) if memory == "llm" else self._unpack(plane, self.dtype)

    def _pack(self, values: Array) -> Bits:
        bits = packed.empty(values.shape)
        packed.pack.for_work(values.size)(grids(values), bits.words)
        return bits

    def _unpack(self, bits: Bits, dtype: np.dtype[Any]) -> Array:
        values = np.empty(bits.shape, dtype)
        black, white = (self._one, self._minus_one) if dtype == self.dtype else (np.True_, np.False_)
        packed.unpack.for_work(values.size)(bits.words, grids(values), black, white)
        return values

    def output(self, x: Array, f: Characteristic = CLIP) -> Array:
        if f != CLIP:
            return f(x)
        y = np.empty_like(x)
        planes.clip.for_work(x.size)(grids(x), grids(y))
        return y

    def transient(
        self, plan: Plan, x: Array, u: Array | None, bias: Array | None = None, mask: Bits | None = None
    ) -> Outcome:
        check_fixed_step(plan)
        held = None if mask is None else self._unpack(mask, np.dtype(bool))
        if plan.method == "general":
            network = TermNetwork(plan, x, u, bias, held)
            with np.errstate(over="ignore", invalid="ignore"):  # overflow is reported below
                steps = DiscreteSteps(network, held) if plan.cell == "discrete-time" else TermSteps(network)
                outcome = driver.run(plan, steps, network.spans())
        else:
            ready = self._ready(plan)
            if plan.method == "closed form":
                end = np.empty_like(x)
                given, work, lines = self._given(plan, ready, x, u, bias, end)
                parts = pieces(lines, (work + (0 if ready.settles else EXPONENTIALS * x.size)) / lines)
                loop, cells = closed.closed_form.for_work(work), _NO_MASK if held is None else grids(held)
                fine = [loop(grids(x), grids(end), cells, ready.cell, given, ready.around_u, *part) for part in parts]
                if not all(fine):
                    check_finite(end, ready.t)
                return Outcome(end, ready.t, ready.settles, 0.0 if ready.settles else math.nan)
            w = self._drive(plan, ready, x, u, bias)
            if mask is None and ready.fuses:
                outcome = ready.euler(plan).run(plan, x, w, self._pool)
                self._pool.keep(w)
            else:  # the result takes the memory of w
                outcome = driver.run(plan, TermSteps(Network(plan, x, w, held)))
        if not planes.all_finite.for_work(x.size)(grids(outcome.x)):
            check_finite(outcome.x, outcome.t)
        return outcome

    def _given(self, plan: Plan, ready: Prepared, x: Array, u: Any, bias: Any, out: Array) -> tuple[Any, int, int]:
        """Return the parts of w = B*u + z + bias, the number of products summed, and the number of rows.

        Terms of the input alone are summed in ``out``, which the caller overwrites row by row.
        """
        bias = with_control_terms(plan, u, bias, out)
        given = ready.z, self._nothing if bias is None else grids(bias), grids(x if u is None else u), ready.control
        return given, x.size * max(1, ready.control.size), x.size // x.shape[-1]

    def _drive(self, plan: Plan, ready: Prepared, x: Array, u: Any, bias: Any) -> Array:
        w = self._pool.plane(x)
        given, work, lines = self._given(plan, ready, x, u, bias, w)
        loop = control.for_work(work)
        for part in pieces(lines, work / lines):
            loop(grids(w), given, ready.around_u, *part)
        return w

    def _ready(self, plan: Plan) -> Prepared:
        ready = self._prepared.get(plan)
        if ready is None:
            ready = self._prepared[plan] = Prepared(plan, self.dtype, numba.get_num_threads())
        return ready

    def cellwise(self, operation: Cellwise, planes: Sequence[Array], parameters: Sequence[float]) -> tuple[Array, ...]:
        if operation.compiled is None:
            return operation.array(*planes, *parameters)
        if operation.name not in self._kernels:
            self._kernels[operation.name] = operation.compiled()
        outputs = tuple(np.empty_like(planes[0]) for _ in operation.outputs)
        flat = [plane.reshape(-1) for plane in (*planes, *outputs)]
        self._kernels[operation.name](*flat, *parameters)
        return outputs

    def logic(self, function: int, p: Bits, q: Bits) -> Bits:
        out = packed.empty(p.shape)
        packed.logic.for_work(out.words.size // 64)(function, p.words, q.words, out.words, p.shape[-1])
        return out

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Bits) -> Bits:
        key = rule, boundary, plane.shape[-2:]
        if key not in self._rules:
            around = virtual_cells(plane.shape, rule.radius, boundary, int(boundary.u > 0))
            self._rules[key] = literals(rule), rule.conjunction, around
        out = packed.empty(plane.shape)
        kernel = neighbourhood.for_work(out.words.size * len(rule.literals) // 64)
        kernel(plane.words, out.words, plane.shape[-1], *self._rules[key])
        return out

    def count(self, plane: Bits) -> int | Integers:
        totals = np.empty(plane.words.shape[0], np.int64)
        packed.count.for_work(plane.words.size // 64)(plane.words, totals)
        return totals if len(plane.shape) == 3 else int(totals[0])

    def prepared(self, routine: Routine) -> Callable[[Stores], Stores | None] | None:
        return CompiledRoutine(routine, self.dtype) if math.prod(routine.shape) <= MOST_CELLS else None


BACKEND = CpuBackend
