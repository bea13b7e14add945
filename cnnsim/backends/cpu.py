"""The CPU backend: numba loops over whole transients, float32 or float64, on all cores."""

import math
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cnnsim.backends import cpu_closed, cpu_kernels
from cnnsim.backends.base import Memory, Outcome, check_finite
from cnnsim.backends.cpu_compile import Kernel
from cnnsim.cellwise import Cellwise
from cnnsim.errors import InputError
from cnnsim.grid import virtual_index
from cnnsim.logic import FUNCTIONS
from cnnsim.plan import SETTLED_SLOPE, Plan
from cnnsim.template import Tap

Array = NDArray[Any]

_NO_MASK = np.empty((1, 1, 0), dtype=bool)
_LOGIC: dict[str, Callable[[Array, Array], Array]] = {
    "nor": lambda p, q: ~(p | q), "not-p-and-q": lambda p, q: ~p & q, "p-and-not-q": lambda p, q: p & ~q,
    "xor": lambda p, q: p ^ q, "nand": lambda p, q: ~(p & q), "and": lambda p, q: p & q, "equal": lambda p, q: ~(p ^ q),
    "not-p-or-q": lambda p, q: ~p | q, "p-or-not-q": lambda p, q: p | ~q, "or": lambda p, q: p | q,
    "not-p": lambda p, _: ~p, "not-q": lambda _, q: ~q, "p": lambda p, _: p.copy(), "q": lambda _, q: q.copy(),
    "white": lambda p, _: np.zeros_like(p), "black": lambda p, _: np.ones_like(p),
}  # fmt: skip


class _Prepared:
    """What a plan looks like in arrays: made at its first transient, kept as long as the plan."""

    def __init__(self, plan: Plan, dtype: np.dtype[Any]) -> None:
        rows, cols = plan.shape
        self.control = _taps(plan.template.control_taps, dtype)
        self.feedback = _taps(plan.feedback_taps, dtype)
        self.around_u = self._around(plan, rows, cols, plan.template.control_taps, plan.boundary.u, dtype)
        self.around_y = self._around(plan, rows, cols, plan.feedback_taps, plan.boundary.y, dtype)
        self.z = dtype.type(plan.template.z)
        self.a = float(plan.template.self_feedback)
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        self.walls = plan.cell == "full-range"
        if plan.scheme is not None:
            h = plan.scheme.gain(plan.step)
            self.ha = (h * plan.scheme.matrix).astype(dtype)
            self.hb = (h * np.array(plan.scheme.b)).astype(dtype)

    @staticmethod
    def _around(
        plan: Plan, rows: int, cols: int, taps: tuple[Tap, ...], constant: float, dtype: np.dtype[Any]
    ) -> tuple[Array, Array, int, Any]:
        r = max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)
        return virtual_index(rows, r, plan.boundary), virtual_index(cols, r, plan.boundary), r, dtype.type(constant)


def _taps(taps: tuple[Tap, ...], dtype: np.dtype[Any]) -> tuple[Array, Array, Array]:
    k, l = (np.array([tap[i] for tap in taps], dtype=np.int64) for i in (0, 1))
    return k, l, np.array([tap.weight for tap in taps], dtype=dtype)


def _grids(plane: Array) -> Array:
    """View (rows, cols) as one grid of a batch."""
    return plane.reshape(-1, *plane.shape[-2:])


class CpuBackend:
    """Planes are contiguous NumPy arrays, in ``dtype`` for LAM and bool for LLM."""

    name = "cpu"

    def __init__(self, dtype: DTypeLike | None = None) -> None:
        self.dtype = np.dtype(np.float32 if dtype is None else dtype)
        if self.dtype not in (np.float32, np.float64):
            raise InputError(f"the cpu backend computes in float32 or float64, not in {self.dtype}")
        self._prepared: WeakKeyDictionary[Plan, _Prepared] = WeakKeyDictionary()
        self._kernels: dict[str, Kernel] = {}

    def load(self, values: Array, memory: Memory) -> Array:
        """See `Backend.load`."""
        if memory == "llm":
            return np.ascontiguousarray(np.asarray(values) > 0)
        return np.array(values, dtype=self.dtype, order="C")

    def read(self, plane: Array) -> Array:
        """See `Backend.read`."""
        return plane.copy()

    def convert(self, plane: Array, memory: Memory) -> Array:
        """See `Backend.convert`."""
        out = np.empty(plane.shape, bool if memory == "llm" else self.dtype)
        kernel = cpu_kernels.binarise if memory == "llm" else cpu_kernels.picture
        kernel.for_work(plane.size)(_grids(plane), _grids(out))
        return out

    def output(self, x: Array) -> Array:
        """See `Backend.output`."""
        y = np.empty_like(x)
        cpu_kernels.clip.for_work(x.size)(_grids(x), _grids(y))
        return y

    def transient(
        self, plan: Plan, x: Array, u: Array | None, bias: Array | None = None, held: Array | None = None
    ) -> Outcome:
        """See `Backend.transient`."""
        ready = self._prepared.get(plan)
        if ready is None:
            ready = self._prepared[plan] = _Prepared(plan, self.dtype)
        w = np.full_like(x, ready.z)
        if bias is not None:
            w += bias
        if u is not None and ready.control[0].size:
            control = cpu_kernels.control.for_work(x.size * ready.control[0].size)
            control(_grids(w), _grids(u), *ready.control, *ready.around_u)
        end = x.copy()
        mask = _NO_MASK if held is None else _grids(held)
        t, settled, slope = self._run(plan, ready, _grids(end), _grids(w), mask)
        if not cpu_kernels.all_finite.for_work(x.size)(_grids(end)):
            check_finite(end, t)
        return Outcome(end, t, settled, slope)

    def _run(self, plan: Plan, ready: _Prepared, x: Array, w: Array, held: Array) -> tuple[float, bool, float]:
        settle = plan.duration == "settled"
        if plan.method == "closed form":
            cpu_closed.closed_form.for_work(x.size)(x, w, held, ready.a, ready.t, ready.walls)
            return ready.t, settle, 0.0 if settle else math.nan
        if plan.method == "adaptive":
            raise InputError(
                "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
            )
        kernel = cpu_kernels.stepped.for_work(x.size * max(1, ready.feedback[0].size))
        done, settled, slope = kernel(
            x, w, held, *ready.feedback, *ready.around_y, ready.ha, ready.hb, plan.steps,
            plan.check_every if settle else 0, SETTLED_SLOPE, plan.step <= 1 and not ready.walls, ready.walls,
        )  # fmt: skip
        return (done * plan.step if settle else ready.t), bool(settled), float(slope)

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

    def logic(self, function: int, p: Array, q: Array) -> Array:
        """See `Backend.logic`."""
        return _LOGIC[FUNCTIONS[function]](p, q)

    def count(self, plane: Array) -> int:
        """See `Backend.count`."""
        return int(np.count_nonzero(plane))
