"""The general road of the OpenCL backend: terms, delays, layers, sequences, any characteristic, discrete time.

The same steps as `cnnsim.backends.cpu_general`, on buffers; what is looked at comes back as a few numbers.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl_build import Workshop, boundary_defines
from cnnsim.backends.wiring import Wiring, characteristic, longest_delay, wire, wire_terms
from cnnsim.frames import at_step, spans
from cnnsim.general import delays_of
from cnnsim.plan import SETTLED_SLOPE, Plan

Buffer = cl.Buffer
Ended = tuple[Buffer, float, bool, float]
_IDENTITY = np.array([0, 0, 0, 0], np.int32)


def control_terms(shop: Workshop, plan: Plan, grids: int, u: Buffer, bias: Buffer | None) -> Buffer:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    wiring = wire_terms(plan, [(0, term) for term in plan.template.control_terms], shop.dtype)
    field = _Field(shop, plan, wiring, grids, 1)
    field.follow(0, u, 0)
    out = shop.buffer(field.count * shop.dtype.itemsize)
    field.base(np.zeros(1), bias, out)
    return field.drives(out, None, out)


class _Field:
    """The channels of a wiring on the device, and the kernels that fill and hear them."""

    def __init__(self, shop: Workshop, plan: Plan, wiring: Wiring, grids: int, layers: int) -> None:
        self.shop, self.plan, self.wiring, self.layers = shop, plan, wiring, layers
        self.size = plan.shape[0] * plan.shape[1]
        self.cells, self.count = grids * self.size, grids * layers * self.size
        self.channels = shop.buffer(max(1, len(wiring.channels)) * self.cells * shop.dtype.itemsize)
        terms = wiring.terms
        self.terms = len(terms.links)
        tables = (terms.links.astype(np.int32), terms.taps.astype(np.int32), terms.weight, terms.planes, terms.numbers)
        inputs = [plan.boundary.u if c.quantity == "u" else plan.boundary.y for c in wiring.channels]
        self.tables = [self._table(table) for table in (*tables, np.array(inputs, shop.dtype))]
        self.shape_of_grid = np.int32(plan.shape[0]), np.int32(plan.shape[1])

    def _table(self, numbers: np.ndarray[Any, Any]) -> Buffer:
        return self.shop.table(np.ascontiguousarray(numbers) if numbers.size else np.zeros(1, numbers.dtype))

    def kernel(self, name: str) -> cl.Kernel:
        """Return a kernel of the general road."""
        return self.shop.kernel(name, "general", boundary_defines(self.plan.boundary))

    def run(self, name: str, work: int, *arguments: Any) -> int:
        """Run a kernel over ``work`` cells; their number is its last argument."""
        return self.shop.run(self.kernel(name), work, *arguments, np.int64(work))

    def base(self, z: np.ndarray[Any, Any], bias: Buffer | None, out: Buffer) -> None:
        """Write z plus the bias map."""
        table = self.shop.table(z.astype(self.shop.dtype))
        self.run(
            "base", self.count, table, bias, out, np.int32(bias is not None), np.int32(self.layers), np.int64(self.size)
        )

    def follow(self, channel: int, state: Buffer, layer: int, through: Any = None) -> None:
        """Bring one layer of a plane into a channel, through a function."""
        links, numbers = (_IDENTITY, np.zeros(1, self.shop.dtype)) if through is None else through
        self.run(
            "follow", self.cells, state, self.channels, self.shop.table(numbers), *map(np.int32, links),
            np.int32(channel), np.int32(layer), np.int32(self.layers), np.int64(self.size),
        )  # fmt: skip

    def drives(self, w: Buffer, stage: Buffer | None, out: Buffer) -> Buffer:
        """Write w plus all terms, less the stage if there is one."""
        self.run(
            "drives", self.count, w, stage, out, self.channels, *self.tables, np.int32(self.terms),
            np.int32(stage is not None), np.int32(self.layers), *self.shape_of_grid,
        )  # fmt: skip
        return out


class _Run:
    """The planes of a run, its past, and what drives each layer. ``u`` and ``bias`` may be `Frames` of buffers."""

    def __init__(self, shop: Workshop, plan: Plan, grids: int, x: Buffer, u: Any, bias: Any, held: Any) -> None:
        assert plan.network is not None
        self.shop, self.plan, self.u, self.bias, self.held = shop, plan, u, bias, held
        layers = len(plan.network.layers)
        wirings = (wire(plan, shop.dtype, static=static) for static in (True, False))
        self.fixed, self.moving = (_Field(shop, plan, wiring, grids // layers, layers) for wiring in wirings)
        self.count, self.x = self.moving.count, x
        self.z = np.array([layer.z for layer in plan.network.layers])
        self.rates = 1 / np.array(plan.network.time_constants)
        self.shape = characteristic(plan, shop.dtype)
        self.past = [x] * (longest_delay(plan, plan.network) + 1)  # before t = 0 the state was x(0)
        self.w = self.new()
        self.common = np.int32(layers), np.int64(self.moving.size), np.int32(plan.shape[1])
        self.mask = np.int32(held is not None)
        self.wall = np.int32(plan.cell == "full-range")

    def new(self) -> Buffer:
        """Return a plane."""
        return cl.Buffer(self.shop.context, cl.mem_flags.READ_WRITE, self.count * self.shop.dtype.itemsize)

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        assert self.plan.network is not None
        return list(spans(self.plan.steps, self.plan.step, delays_of(self.plan.network), self.u, self.bias))

    def stand_still(self, number: int) -> None:
        """Take input and bias as they are from step ``number`` on."""
        step = self.plan.step
        for field in (self.fixed, self.moving):
            for k, channel in enumerate(field.wiring.channels):
                if channel.quantity == "u":
                    field.follow(k, at_step(self.u, number - channel.ago, step), channel.layer)
        self.fixed.base(self.z, at_step(self.bias, number, step), self.w)
        self.fixed.drives(self.w, None, self.w)

    def drive(self, out: Buffer, stage: Buffer, number: int, ahead: int = 0, *, less: bool = True) -> None:
        """Write the drives (``less``: the slopes) in ``stage``, ``ahead`` steps from the start of step ``number``."""
        discrete = self.plan.cell == "discrete-time"
        for k, channel in enumerate(self.moving.wiring.channels):
            if channel.quantity != "u":
                state = self.past[(number + ahead - channel.ago) % len(self.past)] if channel.ago else stage
                through = self.shape if channel.quantity == "y" and not discrete else None
                self.moving.follow(k, state, channel.layer, through)
        self.moving.drives(self.w, stage if less else None, out)

    def combine(
        self, out: Buffer, x: Buffer, slopes: Sequence[Buffer], gains: Buffer, row: Sequence[float], held: Any
    ) -> None:
        """Write x + gain * sum of weight * slope."""
        four = [*slopes[: len(row)], *[None] * (4 - len(row))]
        factors = [self.shop.dtype.type(weight) for weight in (*row, 0.0, 0.0, 0.0, 0.0)[:4]]
        self.moving.run(
            "combine", self.count, x, *four, gains, held, out, *factors, np.int32(len(row)),
            np.int32(held is not None), self.wall, *self.common,
        )  # fmt: skip

    def steepest(self, slope: Buffer, x: Buffer, rates: np.ndarray[Any, Any], *, wall: bool) -> float:
        """Return the largest |slope| of the free cells."""
        parts = self.moving.run(
            "steepest", self.count, slope, x, self.shop.table(rates.astype(self.shop.dtype)), self.held,
            self.shop.partial, self.mask, np.int32(wall), *self.common,
        )  # fmt: skip
        return float(self.shop.parts(parts, self.shop.dtype).max())

    def discrete_step(self, out: Buffer, drive: Buffer, y: Buffer) -> float:
        """Write y(k + 1) and return the largest change."""
        links, numbers = self.shape
        parts = self.moving.run(
            "discrete", self.count, drive, y, out, self.shop.table(numbers), self.held, self.shop.partial,
            *map(np.int32, links), self.mask, np.int32(self.plan.shape[1]),
        )  # fmt: skip
        return float(self.shop.parts(parts, self.shop.dtype).max())


def general(shop: Workshop, plan: Plan, grids: int, x: Buffer, u: Any, bias: Any, held: Buffer | None) -> Ended:
    """Return the state at the end, the time, whether the network settled and the largest |dx/dt|."""
    run = _Run(shop, plan, grids, x, u, bias, held)
    return _discrete(plan, run) if plan.cell == "discrete-time" else _stepped(plan, run)


def _stepped(plan: Plan, run: _Run) -> Ended:
    assert plan.scheme is not None
    scheme, settling = plan.scheme, plan.duration == "settled"
    gains = run.shop.table(np.array([scheme.gain(plan.step * rate) for rate in run.rates]).astype(run.shop.dtype))
    slopes, stage, x = [run.new() for _ in scheme.b], run.new(), run.x

    def look(number: int) -> tuple[bool, float]:
        run.drive(slopes[0], x, number)
        steepest = run.steepest(slopes[0], x, run.rates, wall=bool(run.wall))
        return steepest <= SETTLED_SLOPE, steepest

    spare = [run.new() for _ in range(len(run.past) + 1)]
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            if settling and number % plan.check_every == 0:
                settled, steepest = look(number)
                if settled:
                    return x, number * plan.step, True, steepest
            run.past[number % len(run.past)] = x
            for s, row in enumerate(scheme.a):
                run.combine(stage, x, slopes, gains, row, None)
                run.drive(slopes[s], stage, number, round(sum(row)))
            after = spare[number % len(spare)]  # the one that fell out of the past
            run.combine(after, x, slopes, gains, scheme.b, run.held)
            x = after
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *look(plan.steps)


def _discrete(plan: Plan, run: _Run) -> Ended:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    settling, one = plan.duration == "settled", np.ones(len(run.rates))
    y, drive, change = run.new(), run.new(), math.nan
    run.discrete_step(y, run.x, run.x)
    run.past = [y] * len(run.past)
    before = y
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            run.past[number % len(run.past)] = y
            run.drive(drive, y, number, less=False)
            after = run.new()
            change = run.discrete_step(after, drive, y)
            if settling and (change <= SETTLED_SLOPE or (number and _same(run, after, before, one))):
                return y, float(number), change <= SETTLED_SLOPE, change
            before, y = y, after
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)


def _same(run: _Run, a: Buffer, b: Buffer, one: np.ndarray[Any, Any]) -> bool:
    """Return whether two states are the same."""
    difference = run.new()
    run.combine(difference, a, [b], run.shop.table(one.astype(run.shop.dtype)), [-1.0], None)
    return run.steepest(difference, a, one, wall=False) == 0
