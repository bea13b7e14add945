"""The general road of the OpenCL backend: terms, delays, layers, sequences, any characteristic, discrete time.

The same steps as `cnnsim.backends.cpu_general`, on buffers; what is looked at comes back as a few numbers.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl_build import Workshop, boundary_defines, source
from cnnsim.backends.opencl_terms import term_defines
from cnnsim.backends.wiring import Wiring, characteristic, longest_delay, wire, wire_terms
from cnnsim.frames import at_step, spans
from cnnsim.general import delays_of
from cnnsim.plan import SETTLED_SLOPE, Plan

Buffer = cl.Buffer
Ended = tuple[Buffer, float, bool, float]
_DRIVE, _SLOPE, _STEP, _DISCRETE = range(4)


def control_terms(shop: Workshop, plan: Plan, grids: int, u: Buffer, bias: Buffer | None) -> Buffer:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    wiring = wire_terms(plan, [(0, term) for term in plan.template.control_terms], shop.dtype)
    field = _Field(shop, plan, [wiring], 0, grids, 1)
    field.follow(0, u, 0)
    out = shop.buffer(field.count * shop.dtype.itemsize)
    field.base(np.zeros(1), bias, out)
    return field.advance(_DRIVE, out, None, out)


class _Field:
    """The channels of a wiring on the device with their virtual cells, and the kernels that fill and hear them.

    Of all ``wirings`` of a run, which share one program, it is number ``part``.
    """

    def __init__(
        self, shop: Workshop, plan: Plan, wirings: Sequence[Wiring], part: int, grids: int, layers: int,
        gains: np.ndarray[Any, Any] | None = None, held: Buffer | None = None,
    ) -> None:  # fmt: skip
        self.shop, self.plan, self.wiring, self.layers = shop, plan, wirings[part], layers
        (rows, cols), r = plan.shape, self.wiring.radius
        self.size, self.lines, self.count = rows * cols, grids * layers * rows, grids * layers * rows * cols
        self.tall, self.wide = grids * (rows + 2 * r), cols + 2 * r
        stride = -(-(self.wide + shop.lanes) // shop.lanes) * shop.lanes
        channel = self.tall * stride
        self.channels = shop.buffer(max(1, len(self.wiring.channels)) * channel * shop.dtype.itemsize)
        self.planes = self._table(np.append(self.wiring.terms.planes.ravel(), np.zeros(shop.lanes, shop.dtype)))
        self.gains = self._table(np.ones(layers, shop.dtype) if gains is None else gains)
        self.grid = (*map(np.int32, (r, stride, rows, cols)), np.int64(channel))
        self.part, self.none = np.int32(part), np.int32(len(wirings))
        self.wall, self.held = np.int32(plan.cell == "full-range"), held
        shape = characteristic(plan, shop.dtype) if plan.method == "general" else None
        self.defines = {
            **term_defines([wiring.terms for wiring in wirings], layers, shape, shop.dtype),
            **boundary_defines(plan.boundary),
        }

    def _table(self, numbers: np.ndarray[Any, Any]) -> Buffer:
        return self.shop.table(np.ascontiguousarray(numbers))

    def kernel(self, name: str) -> cl.Kernel:
        """Return a kernel that knows the terms."""
        return self.shop.kernel(name, "general", self.defines, source("terms"))

    def run(self, name: str, work: int, *arguments: Any) -> int:
        """Run a kernel that knows no terms over ``work`` cells; their number is its last argument."""
        return self.shop.run(self.shop.kernel(name, "general", {}), work, *arguments, np.int64(work))

    def base(self, z: np.ndarray[Any, Any], bias: Buffer | None, out: Buffer) -> None:
        """Write z plus the bias map."""
        table = self.shop.table(z.astype(self.shop.dtype))
        self.run(
            "base", self.count, table, bias, out, np.int32(bias is not None), np.int32(self.layers), np.int64(self.size)
        )

    def follow(self, channel: int, state: Buffer, layer: int, *, through: bool = False) -> None:
        """Bring one layer of a plane into a channel, perhaps through the output characteristic."""
        quantity = self.wiring.channels[channel].quantity
        outside = self.plan.boundary.u if quantity == "u" else self.plan.boundary.y
        self._over_rows(
            "follow", self.tall, self.wide, state, self.channels,
            *map(np.int32, (channel, layer, self.layers, through)), self.shop.dtype.type(outside),
        )  # fmt: skip

    def advance(self, task: int, w: Buffer, x: Buffer | None, out: Buffer, *, terms: bool = True) -> Buffer:
        """Write w plus all terms; or less x, the slope; or where a step from x leads; or its output (discrete time)."""
        self._over_rows(
            "advance", self.lines, self.plan.shape[1], w if x is None else x, w, self.held, out, self.channels,
            self.planes, self.gains, np.int32(task), self.part if terms else self.none,
            np.int32(self.held is not None), self.wall, np.int32(self.layers),
        )  # fmt: skip
        return out

    def _over_rows(self, name: str, rows: int, cols: int, *arguments: Any) -> None:
        """Run a kernel whose work-items take rows on a CPU and cells on a GPU."""
        work = rows if self.shop.family == "cpu" else rows * cols
        self.shop.run(self.kernel(name), rows * cols, *arguments, *self.grid, np.int64(work))


class _Run:
    """The planes of a run, its past, and what drives each layer. ``u`` and ``bias`` may be `Frames` of buffers."""

    def __init__(self, shop: Workshop, plan: Plan, grids: int, x: Buffer, u: Any, bias: Any, held: Any) -> None:
        assert plan.network is not None
        self.shop, self.plan, self.u, self.bias, self.held = shop, plan, u, bias, held
        layers = len(plan.network.layers)
        wirings = [wire(plan, shop.dtype, static=static) for static in (True, False)]
        self.rates = 1 / np.array(plan.network.time_constants)
        gains = [plan.scheme.gain(plan.step * rate) if plan.scheme else 1.0 for rate in self.rates]
        self.gains = np.array(gains, shop.dtype)
        self.fixed, self.moving = (
            _Field(shop, plan, wirings, part, grids // layers, layers, self.gains, held) for part in (0, 1)
        )
        self.count, self.x = self.moving.count, x
        self.z = np.array([layer.z for layer in plan.network.layers])
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
        self.fixed.advance(_DRIVE, self.w, None, self.w)

    def advance(self, task: int, out: Buffer, stage: Buffer, number: int) -> None:
        """Do a task of `_Field.advance` with the drives in ``stage`` at the start of step ``number``."""
        discrete = self.plan.cell == "discrete-time"
        for k, channel in enumerate(self.moving.wiring.channels):
            if channel.quantity != "u":
                state = self.past[(number - channel.ago) % len(self.past)] if channel.ago else stage
                self.moving.follow(k, state, channel.layer, through=channel.quantity == "y" and not discrete)
        self.moving.advance(task, self.w, stage, out)

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

    def change(self, a: Buffer, b: Buffer) -> float:
        """Return the largest difference of two planes."""
        parts = self.moving.run("change", self.count, a, b, self.shop.partial)
        return float(self.shop.parts(parts, self.shop.dtype).max())


def general(shop: Workshop, plan: Plan, grids: int, x: Buffer, u: Any, bias: Any, held: Buffer | None) -> Ended:
    """Return the state at the end, the time, whether the network settled and the largest |dx/dt|."""
    run = _Run(shop, plan, grids, x, u, bias, held)
    return _discrete(plan, run) if plan.cell == "discrete-time" else _stepped(plan, run)


def _stepped(plan: Plan, run: _Run) -> Ended:
    assert plan.scheme is not None
    scheme, settling = plan.scheme, plan.duration == "settled"
    several = len(scheme.b) > 1
    gains = run.shop.table(run.gains)
    slopes, x = [run.new() for _ in scheme.b], run.x
    stage = run.new() if several else x

    def look(number: int) -> tuple[bool, float]:
        run.advance(_SLOPE, slopes[0], x, number)
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
            after = spare[number % len(spare)]  # the one that fell out of the past
            if several:
                for s, row in enumerate(scheme.a):
                    run.combine(stage, x, slopes, gains, row, None)
                    run.advance(_SLOPE, slopes[s], stage, number + round(sum(row)))
                run.combine(after, x, slopes, gains, scheme.b, run.held)
            else:
                run.advance(_STEP, after, x, number)
            x = after
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *look(plan.steps)


def _discrete(plan: Plan, run: _Run) -> Ended:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    settling, change = plan.duration == "settled", math.nan
    spare = [run.new() for _ in range(len(run.past) + 2)]
    before, y = run.x, run.moving.advance(_DISCRETE, run.x, run.x, run.new(), terms=False)
    run.past = [y] * len(run.past)
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            run.past[number % len(run.past)] = y
            after = spare[number % len(spare)]  # the one that fell out of the past
            run.advance(_DISCRETE, after, y, number)
            if settling:
                change = run.change(after, y)
                if change <= SETTLED_SLOPE or (number and run.change(after, before) == 0):
                    return y, float(number), change <= SETTLED_SLOPE, change
            before, y = y, after
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)
