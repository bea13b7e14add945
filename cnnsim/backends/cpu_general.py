"""The general road of the CPU backend: terms, delays, layers, sequences, any characteristic, discrete time.

The loop over steps calls a few compiled loops over all cells; what the input alone drives is added up once in each
span of time in which the input stands still.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.backends import cpu_general_kernels as kernels
from cnnsim.backends.base import Outcome, check_finite
from cnnsim.backends.wiring import Wiring, characteristic, longest_delay, wire, wire_terms
from cnnsim.errors import InputError
from cnnsim.frames import Frames, at_step, spans
from cnnsim.general import delays_of
from cnnsim.grid import virtual_index
from cnnsim.plan import SETTLED_SLOPE, Plan

Array = NDArray[Any]


def with_control_terms(plan: Plan, u: Array | None, bias: Array | None) -> Array | None:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    terms = plan.template.control_terms
    if u is None or not terms:
        return bias
    rows, cols = u.shape[-2:]
    total = np.zeros(u.shape, u.dtype) if bias is None else bias.copy()
    wiring = wire_terms(plan, [(0, term) for term in terms], u.dtype)
    field = _Field(plan, wiring, total.size // (rows * cols), u.dtype)
    field.fill(0, u.reshape(-1, rows, cols), plan.boundary.u)
    shape = (-1, 1, rows, cols)
    kernels.static_drive.for_work(total.size * 9)(total.reshape(shape), field.around, *wiring.terms, wiring.radius)
    return total


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


class _Field:
    """The channels of a wiring with their virtual cells."""

    def __init__(self, plan: Plan, wiring: Wiring, grids: int, dtype: np.dtype[Any]) -> None:
        r, (rows, cols) = wiring.radius, plan.shape
        self.wiring, self.r = wiring, r
        self.rows, self.cols = virtual_index(rows, r, plan.boundary), virtual_index(cols, r, plan.boundary)
        self.around = np.zeros((max(1, len(wiring.channels)), grids, rows + 2 * r, cols + 2 * r), dtype)

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
        self.held = np.empty((1, 1, 1, 0), bool) if held is None else held.reshape(self.shape)
        self.z = np.array([layer.z for layer in layers], x.dtype).reshape(-1, 1, 1)
        self.fixed, self.moving = (
            _Field(plan, wire(plan, x.dtype, static=static), self.shape[0], x.dtype) for static in (True, False)
        )
        channels = self.moving.wiring.channels
        follow = [(number, c) for number, c in enumerate(channels) if c.quantity != "u"]
        self.numbers = np.array([number for number, _ in follow], np.int64)
        self.layers = np.array([c.layer for _, c in follow], np.int64)
        self.ago = np.array([c.ago for _, c in follow], np.int64)
        self.outputs = np.array([c.quantity == "y" and plan.cell != "discrete-time" for _, c in follow], bool)
        self.characteristic = characteristic(plan, x.dtype)
        self.past = np.empty((longest_delay(plan, plan.network) + 1, *self.shape), x.dtype)
        self.past[:] = self.x  # before t = 0 the state was x(0)
        self.w = np.empty_like(self.x)
        self.work = self.x.size * max(1, len(self.moving.wiring.terms.taps))
        self.wall = plan.cell == "full-range"

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
            for k, channel in enumerate(field.wiring.channels):
                if channel.quantity == "u":
                    heard = at_step(self.u, number - channel.ago, plan.step)[:, channel.layer]
                    field.fill(k, heard, plan.boundary.u)
        terms = self.fixed.wiring.terms
        work = self.w.size * max(1, len(terms.taps))
        kernels.static_drive.for_work(work)(self.w, self.fixed.around, *terms, self.fixed.r)

    def drive(self, out: Array, stage: Array, number: int, ahead: int = 0) -> None:
        """Write the drives in state ``stage``, ``ahead`` (0 or 1) steps from the start of step ``number``."""
        slots = np.where(self.ago > 0, (number + ahead - self.ago) % len(self.past), -1)
        field = self.moving
        kernels.drives.for_work(self.work)(
            out, stage, self.w, self.past, slots, field.around, self.numbers, self.layers, self.outputs,
            *self.characteristic, *field.wiring.terms, field.rows, field.cols, field.r,
            self.dtype.type(self.plan.boundary.y),
        )  # fmt: skip


def _stepped(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    assert plan.scheme is not None and plan.network is not None
    scheme, settling = plan.scheme, plan.duration == "settled"
    rates = np.array([1 / time for time in plan.network.time_constants])
    gains = np.array([scheme.gain(plan.step * rate) for rate in rates]).astype(run.dtype)
    rates = rates.astype(run.dtype)
    a = [np.array(row, run.dtype) for row in scheme.a]
    b, ahead = np.array(scheme.b, run.dtype), [round(sum(row)) for row in scheme.a]
    nobody = run.held[..., :0]
    slopes, x = np.empty((len(b), *run.shape), run.dtype), run.x.copy()
    stage = np.empty_like(x)
    combine = kernels.combine.for_work(x.size)

    def look(number: int) -> tuple[bool, float]:
        run.drive(slopes[0], x, number)
        steepest = kernels.steepest_of.for_work(x.size)(slopes[0], x, rates, run.held, run.wall)
        return steepest <= SETTLED_SLOPE, steepest

    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            if settling and number % plan.check_every == 0:
                settled, steepest = look(number)
                if settled:
                    return x, number * plan.step, True, steepest
            run.past[number % len(run.past)] = x
            for s, row in enumerate(a):
                combine(stage, x, slopes, gains, row, nobody, run.wall)
                run.drive(slopes[s], stage, number, ahead[s])
                slopes[s] -= stage
            combine(x, x, slopes, gains, b, run.held, run.wall)
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *look(plan.steps)


def _discrete(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    settling, step = plan.duration == "settled", kernels.discrete_step.for_work(run.x.size)
    y, after, before, drive = np.empty_like(run.x), np.empty_like(run.x), run.x, np.empty_like(run.x)
    kernels.discrete_step.serial(y, run.x, run.x, *run.characteristic, run.held)
    run.past[:] = y
    change = math.nan
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            run.past[number % len(run.past)] = y
            run.drive(drive, y, number)
            change = step(after, drive, y, *run.characteristic, run.held)
            if settling and (change <= SETTLED_SLOPE or (number and np.array_equal(after, before))):
                return y, float(number), change <= SETTLED_SLOPE, change
            before, y, after = y, after, np.empty_like(y)
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)
