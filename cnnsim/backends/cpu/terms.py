"""The general road of the CPU backend: terms, delays, layers, sequences, any characteristic, discrete time.

The loop over steps calls a few compiled loops over all cells; what the input alone drives is added up once in each
span of time in which the input stands still.
"""

import math
from typing import Any

import numba
import numpy as np

from cnnsim.backends.base import Outcome, check_finite
from cnnsim.backends.cpu import term_loops as kernels
from cnnsim.backends.cpu.jit.compile import THREADS_PAY_FROM
from cnnsim.backends.term_table import TermTable, characteristic, longest_delay, table_of, tabulate
from cnnsim.network import Frames
from cnnsim.network.boundary import virtual_index
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array, InputError

NOBODY = np.empty((1, 1, 1, 0), bool)
"""The mask that holds no cell."""


def with_control_terms(plan: Plan, u: Array | None, bias: Array | None) -> Array | None:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    terms = plan.template.control_terms
    if u is None or not terms:
        return bias
    rows, cols = u.shape[-2:]
    total = np.zeros(u.shape, u.dtype) if bias is None else bias.copy()
    table = tabulate(plan, [(0, term) for term in terms], u.dtype)
    field = _Field(plan, table, total.size // (rows * cols), u.dtype)
    field.fill(0, u.reshape(-1, rows, cols), plan.boundary.u)
    shape = (-1, 1, rows, cols)
    field.add_to(total.reshape(shape))
    return total


def threads_for(work: int) -> int:
    """Return among how many threads the rows are shared: as many as run the version of a loop for this much work."""
    return numba.get_num_threads() if work >= THREADS_PAY_FROM else 1


def addresses(dtype: np.dtype[Any]) -> list[int]:
    """Return where the functions are that `kernels.advance` calls."""
    return [function.address for function in kernels.shared(dtype)]


def transient(plan: Plan, x: Array, u: Any, bias: Any, held: Array | None) -> Outcome:
    """Run a plan whose method is "general"; see `Backend.transient`. ``u`` and ``bias`` may be `Frames`."""
    if plan.cell != "discrete-time" and plan.scheme is None:
        raise InputError(
            "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
        )
    run = _Run(plan, x, u, bias, held)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is found and reported below
        end, t, settled, slope = (_discrete if plan.cell == "discrete-time" else _stepped)(plan, run)
    end = end.reshape(x.shape).copy()
    check_finite(end, t)
    return Outcome(end, t, settled, slope)


def _flat(table: TermTable) -> tuple[Array, ...]:
    links = np.ascontiguousarray(np.stack(table.terms, axis=1))
    taps = np.ascontiguousarray(np.stack([table.taps.k, table.taps.l, table.taps.plane], axis=1))
    return links, taps, table.taps.weight, table.planes, table.numbers


class _Field:
    """The channels of a table of terms with their virtual cells."""

    def __init__(self, plan: Plan, table: TermTable, grids: int, dtype: np.dtype[Any]) -> None:
        r, (rows, cols) = table.radius, plan.shape
        self.table, self.r = table, r
        self.rows, self.cols = virtual_index(rows, r, plan.boundary), virtual_index(cols, r, plan.boundary)
        self.around = np.zeros((max(1, len(table.channels)), grids, rows + 2 * r, cols + 2 * r), dtype)

    def add_to(self, w: Array) -> None:
        """Add the terms of channels that stand still to w."""
        work, nobody, flat = w.size * max(1, len(self.table.taps.k)), np.empty(0, np.int64), w.reshape(-1)
        kernels.advance.for_work(work)(
            *addresses(w.dtype),
            kernels.DRIVE, w, flat, w, 0, 1, nobody, flat, NOBODY, False, threads_for(work), w, w[None], self.around,
            nobody, nobody, nobody > 0, np.zeros(4, np.int64), flat, self.rows, self.cols, w.dtype.type(0), self.r,
            *_flat(self.table),
        )  # fmt: skip

    def fill(self, channel: int, source: Array, constant: float) -> None:
        """Bring a plane (n, rows, cols) into a channel."""
        kernels.fill_channel.for_work(source.size)(
            self.around[channel], source, self.rows, self.cols, self.r, self.around.dtype.type(constant)
        )


class _Run:
    """The planes of a run, its past, and what drives each layer."""

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, held: Array | None) -> None:
        assert plan.network is not None
        self.plan, self.dtype, layers = plan, x.dtype, plan.network.layers
        self.shape = (x.size // (len(layers) * plan.shape[0] * plan.shape[1]), len(layers), *plan.shape)
        self.x = x.reshape(self.shape)
        self.u, self.bias = self._planes(u), self._planes(bias)
        self.held = NOBODY if held is None else held.reshape(self.shape)
        self.z = np.array([layer.z for layer in layers], x.dtype).reshape(-1, 1, 1)
        self.fixed, self.moving = (
            _Field(plan, table_of(plan, x.dtype, static=static), self.shape[0], x.dtype) for static in (True, False)
        )
        channels = self.moving.table.channels
        follow = [(number, c) for number, c in enumerate(channels) if c.quantity != "u"]
        self.numbers = np.array([number for number, _ in follow], np.int64)
        self.layers = np.array([c.layer for _, c in follow], np.int64)
        self.ago = np.array([c.ago for _, c in follow], np.int64)
        self.outputs = np.array([c.quantity == "y" and plan.cell != "discrete-time" for _, c in follow], bool)
        self.characteristic = characteristic(plan, x.dtype)
        self.constant = x.dtype.type(plan.boundary.y)
        self.largest = np.empty(self.x.size // plan.shape[1], x.dtype)
        self.rates = 1 / np.array(plan.network.time_constants)
        self.gains = np.array(
            [plan.scheme.gain(plan.step * rate) if plan.scheme else 1.0 for rate in self.rates], x.dtype
        )
        self.past = np.empty((longest_delay(plan, plan.network) + 1, *self.shape), x.dtype)
        self.past[:] = self.x  # before t = 0 the state was x(0)
        self.w = np.empty_like(self.x)
        self.work = self.x.size * max(1, len(self.moving.table.taps.k))
        self.wall = plan.cell == "full-range"
        self.addresses = addresses(x.dtype)
        self.hearing = (
            self.moving.around, self.numbers, self.layers, self.outputs, np.array(self.characteristic[:4], np.int64),
            self.characteristic.numbers, self.moving.rows, self.moving.cols, self.constant, self.moving.r,
            *_flat(self.moving.table),
        )  # fmt: skip

    def _planes(self, value: Any) -> Any:
        if value is None:
            return None
        return value.map(self._planes) if isinstance(value, Frames) else value.reshape(self.shape)

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        assert self.plan.network is not None
        return list(spans(self.plan.steps, self.plan.step, delays_of(self.plan.network), self.u, self.bias))

    def stand_still(self, number: int) -> None:
        """Take input and bias as they are from step ``number`` on."""
        plan = self.plan
        self.w[:] = self.z
        if self.bias is not None:
            self.w += at_step(self.bias, number, plan.step)
        for field in (self.fixed, self.moving):
            for k, channel in enumerate(field.table.channels):
                if channel.quantity == "u":
                    heard = at_step(self.u, number - channel.ago, plan.step)[:, channel.layer]
                    field.fill(k, heard, plan.boundary.u)
        self.fixed.add_to(self.w)

    def advance(self, task: int, out: Array, x: Array, number: int, count: int = 1) -> float:
        """Do a task of `kernels.advance` with the drives in state x; return the largest change, of discrete steps."""
        kernels.advance.for_work(self.work)(
            *self.addresses, task, out, self.largest, x, number, count, self.ago, self.gains, self.held, self.wall,
            threads_for(self.work), self.w, self.past, *self.hearing,
        )  # fmt: skip
        return float(self.largest.max()) if task == kernels.DISCRETE else math.nan


def _stepped(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    assert plan.scheme is not None
    settling, x = plan.duration == "settled", run.x.copy()
    slopes = np.empty((len(plan.scheme.b), *run.shape), run.dtype)
    step = _euler if len(plan.scheme.b) == 1 else _several_stages

    def look(number: int) -> tuple[bool, float]:
        run.advance(kernels.DRIVE, slopes[0], x, number)
        steepest = kernels.steepest_of.for_work(x.size)(slopes[0], x, run.rates.astype(run.dtype), run.held, run.wall)
        return steepest <= SETTLED_RATE, steepest

    for first, count in run.spans():
        run.stand_still(first)
        number, end = first, first + count
        while number < end:
            if settling and number % plan.check_every == 0:
                settled, steepest = look(number)
                if settled:
                    return x, number * plan.step, True, steepest
            until = min(end, (number // plan.check_every + 1) * plan.check_every) if settling else end
            step(plan, run, x, slopes, number, until - number)
            number = until
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *look(plan.steps)


def _euler(_plan: Plan, run: _Run, x: Array, slopes: Array, first: int, count: int) -> None:
    run.advance(kernels.EULER, slopes[0], x, first, count)


def _several_stages(plan: Plan, run: _Run, x: Array, slopes: Array, first: int, count: int) -> None:
    assert plan.scheme is not None
    a, b = [np.array(row, run.dtype) for row in plan.scheme.a], np.array(plan.scheme.b, run.dtype)
    stage, combine = np.empty_like(x), kernels.combine.for_work(x.size)
    for number in range(first, first + count):
        run.past[number % len(run.past)] = x
        for s, row in enumerate(a):
            combine(stage, x, slopes, run.gains, row, NOBODY, run.wall)
            run.advance(kernels.SLOPE, slopes[s], stage, number + round(float(row.sum())))
        combine(x, x, slopes, run.gains, b, run.held, run.wall)


def _discrete(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    settling = plan.duration == "settled"
    y = plan.characteristic(run.x)
    y = np.where(run.held, run.x, y) if run.held.size else y
    before, after, change = run.x, np.empty_like(y), math.nan
    run.past[:] = y
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            run.past[number % len(run.past)] = y
            change = run.advance(kernels.DISCRETE, after, y, number)
            if settling and (change <= SETTLED_RATE or (number and np.array_equal(after, before))):
                return y, float(number), change <= SETTLED_RATE, change
            before, y, after = y, after, np.empty_like(y)
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)
