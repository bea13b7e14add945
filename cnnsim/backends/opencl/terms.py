"""The general road of the OpenCL backend: terms, delays, layers, sequences, any characteristic, discrete time.

The same steps as `cnnsim.backends.cpu.terms`, on buffers; what is looked at comes back as a few numbers.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.build import Workshop
from cnnsim.backends.opencl.term_field import DISCRETE, DRIVE, SLOPE, STEP, Field
from cnnsim.backends.term_table import longest_delay, table_of, tabulate
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import SETTLED_RATE, Plan

Buffer = cl.Buffer
Ended = tuple[Buffer, float, bool, float]


def control_terms(shop: Workshop, plan: Plan, grids: int, u: Buffer, bias: Buffer | None) -> Buffer:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    table = tabulate(plan, [(0, term) for term in plan.template.control_terms], shop.dtype)
    field = Field(shop, plan, [table], 0, grids, 1)
    field.follow(0, u, 0)
    out = shop.buffer(field.count * shop.dtype.itemsize)
    field.base(np.zeros(1), bias, out)
    return field.advance(DRIVE, out, None, out)


class _Run:
    """The planes of a run, its past, and what drives each layer. ``u`` and ``bias`` may be `Frames` of buffers."""

    def __init__(self, shop: Workshop, plan: Plan, grids: int, x: Buffer, u: Any, bias: Any, held: Any) -> None:
        assert plan.network is not None
        self.shop, self.plan, self.u, self.bias, self.held = shop, plan, u, bias, held
        layers = len(plan.network.layers)
        tables = [table_of(plan, shop.dtype, static=static) for static in (True, False)]
        self.rates = 1 / np.array(plan.network.time_constants)
        gains = [plan.scheme.gain(plan.step * rate) if plan.scheme else 1.0 for rate in self.rates]
        self.gains = np.array(gains, shop.dtype)
        self.fixed, self.moving = (
            Field(shop, plan, tables, part, grids // layers, layers, self.gains, held) for part in (0, 1)
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
            for k, channel in enumerate(field.table.channels):
                if channel.quantity == "u":
                    field.follow(k, at_step(self.u, number - channel.ago, step), channel.layer)
        self.fixed.base(self.z, at_step(self.bias, number, step), self.w)
        self.fixed.advance(DRIVE, self.w, None, self.w)

    def advance(self, task: int, out: Buffer, stage: Buffer, number: int) -> None:
        """Do a task of `Field.advance` with the drives in ``stage`` at the start of step ``number``."""
        discrete = self.plan.cell == "discrete-time"
        for k, channel in enumerate(self.moving.table.channels):
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
        run.advance(SLOPE, slopes[0], x, number)
        steepest = run.steepest(slopes[0], x, run.rates, wall=bool(run.wall))
        return steepest <= SETTLED_RATE, steepest

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
                    run.advance(SLOPE, slopes[s], stage, number + round(sum(row)))
                run.combine(after, x, slopes, gains, scheme.b, run.held)
            else:
                run.advance(STEP, after, x, number)
            x = after
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *look(plan.steps)


def _discrete(plan: Plan, run: _Run) -> Ended:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    settling, change = plan.duration == "settled", math.nan
    spare = [run.new() for _ in range(len(run.past) + 2)]
    before, y = run.x, run.moving.advance(DISCRETE, run.x, run.x, run.new(), terms=False)
    run.past = [y] * len(run.past)
    for first, count in run.spans():
        run.stand_still(first)
        for number in range(first, first + count):
            run.past[number % len(run.past)] = y
            after = spare[number % len(spare)]  # the one that fell out of the past
            run.advance(DISCRETE, after, y, number)
            if settling:
                change = run.change(after, y)
                if change <= SETTLED_RATE or (number and run.change(after, before) == 0):
                    return y, float(number), change <= SETTLED_RATE, change
            before, y = y, after
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)
