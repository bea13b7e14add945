"""The general road of the reference backend: terms, delays, layers, sequences, any characteristic, discrete time.

Planes are seen as (n, layers, rows, cols). Slow and obvious: every neighbour of every term is looked up anew.
"""

import math
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from cnnsim.backends.base import Outcome, check_finite
from cnnsim.network.boundary import Boundary, pad
from cnnsim.network.frames import Frames, at_step
from cnnsim.network.template import Template
from cnnsim.network.term import Argument, Quantity, Term
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support.errors import InputError
from cnnsim.support.types import Array

Look = Callable[[Quantity, int], Array]
"""What a term sees: (quantity, layer) -> (n, rows, cols), at the time the term looks at."""


def add_term(total: Array, term: Term, own: int, look: Look, boundary: Boundary) -> None:
    """Add one term to the drive (n, rows, cols) of layer ``own``."""
    rows, cols = total.shape[-2:]
    r = term.radius
    other = own if term.layer is None else term.layer

    def value(argument: Argument, k: int, l: int) -> Array:
        constant = boundary.u if argument.neighbour == "u" else boundary.y
        around = pad(look(argument.neighbour, other), r, boundary, constant)
        there = around[..., r + k : r + k + rows, r + l : r + l + cols]
        return there if argument.centre is None else there - look(argument.centre, own)

    for k, l, weight in term.taps:
        v = value(term.of, k, l)
        f = v if term.table is None else term.table(v)
        total += weight * (f if term.times is None else f * value(term.times, k, l))


def with_control_terms(template: Template, boundary: Boundary, u: Array | None, bias: Array | None) -> Array | None:
    """Return the bias map plus all terms of the input alone: the linear roads need no more."""
    if u is None or not template.control_terms:
        return bias
    total = np.zeros_like(u) if bias is None else bias.copy()
    for term in template.control_terms:
        add_term(total, term, 0, lambda _quantity, _layer: u, boundary)
    return total


def transient(plan: Plan, x: Array, u: Any, bias: Any, held: Array | None) -> Outcome:
    """Run a plan whose method is "general"; see `Backend.transient`. ``u`` and ``bias`` may be `Frames`."""
    run = _Run(plan, x, u, bias, held)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is found and reported below
        road = _discrete if plan.cell == "discrete-time" else _adaptive if plan.scheme is None else _stepped
        end, t, settled, slope = road(plan, run)
    end = end.reshape(x.shape)
    check_finite(end, t)
    return Outcome(end, t, settled, slope)


class _Run:
    """The planes of a run, its past, and what drives each layer."""

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, held: Array | None) -> None:
        assert plan.network is not None
        self.plan, self.network = plan, plan.network
        self.shape = (-1, len(self.network.layers), *x.shape[-2:])
        self.x = x.reshape(self.shape)
        self.u, self.bias = self._planes(u), self._planes(bias)
        self.free = np.ones(self.x.shape, dtype=bool) if held is None else ~held.reshape(self.shape)
        longest = max((round(delay / plan.step) for delay in delays_of(self.network)), default=0)
        self.past: deque[Array] = deque([self.x], maxlen=longest + 1)
        self.rates = 1 / np.array(self.network.time_constants).reshape(-1, 1, 1)
        self.wall = plan.cell == "full-range"
        self.terms = [
            (Term(layer.B, "u_kl"), *layer.control_terms, Term(layer.A, "y_kl"), *layer.feedback_terms)
            for layer in self.network.layers
        ]

    def _planes(self, value: Any) -> Any:
        if value is None:
            return None
        return value.map(self._planes) if isinstance(value, Frames) else value.reshape(self.shape)

    def output(self, x: Array) -> Array:
        """y; in discrete time the state is the output already."""
        return x if self.plan.cell == "discrete-time" else self.plan.characteristic(x)

    def drive(self, now: Array, number: int, ahead: int = 0) -> Array:
        """Return all layers' drives in state ``now``, ``ahead`` (0 or 1) steps from the start of step ``number``."""
        step, boundary = self.plan.step, self.plan.boundary
        total = np.empty_like(now)

        def look(delay: float) -> Look:
            ago = round(delay / step)
            # A step sees the input of its start to its end; before t = 0 the state was x(0) and the input the first.
            state = now if not ago else self.past[max(-len(self.past), ahead - 1 - ago)]

            def seen(quantity: Quantity, layer: int) -> Array:
                if quantity == "u":
                    return at_step(self.u, number - ago, step)[:, layer]
                return (state if quantity == "x" else self.output(state))[:, layer]

            return seen

        for number_of_layer, layer in enumerate(self.network.layers):
            part = np.full_like(now[:, 0], layer.z)
            if self.bias is not None:
                part += at_step(self.bias, number, step)[:, number_of_layer]
            for term in self.terms[number_of_layer]:
                add_term(part, term, number_of_layer, look(term.delay), boundary)
            total[:, number_of_layer] = part
        return total

    def steepness(self, slope: Array) -> float:
        """The largest |dx/dt| of the free cells."""
        return float(np.abs(slope[self.free]).max(initial=0.0))


def _stepped(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    assert plan.scheme is not None
    x, scheme, settling = run.x, plan.scheme, plan.duration == "settled"
    gains = np.array([scheme.gain(plan.step * rate) for rate in run.rates.ravel()]).reshape(run.rates.shape)
    for number in range(plan.steps):
        if settling and number % plan.check_every == 0:
            settled, steepest = _look(plan, run, x, number)
            if settled:
                return x, number * plan.step, True, steepest
        run.past.append(x)
        slopes: list[Array] = []
        for row in scheme.a:
            stage = x + gains * sum(weight * k for weight, k in zip(row, slopes, strict=True))
            stage = stage.clip(-1, 1) if run.wall else stage
            slopes.append(run.drive(stage, number, round(sum(row))) - stage)
        after = x + gains * sum(weight * k for weight, k in zip(scheme.b, slopes, strict=True))
        x = np.where(run.free, after.clip(-1, 1) if run.wall else after, x)
    if not settling:
        return x, float(plan.duration), False, math.nan
    return x, plan.steps * plan.step, *_look(plan, run, x, plan.steps)


def _look(plan: Plan, run: _Run, x: Array, number: int) -> tuple[bool, float]:
    drive = run.drive(x, number)
    slope = (drive - x) * run.rates
    if run.wall:
        slope = np.where(((x >= 1) & (slope > 0)) | ((x <= -1) & (slope < 0)), 0.0, slope)
    steepest = run.steepness(slope)
    return steepest <= SETTLED_RATE, steepest


def _discrete(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    """y(k + 1) = f(drive); at rest when nothing changes. A cycle of two steps never ends, so it is left at once."""
    sign, settling = plan.characteristic.kind == "sign", plan.duration == "settled"
    y = run.x = np.where(run.free, plan.characteristic(run.x), run.x)
    before, change = y, math.nan
    run.past = deque([y], maxlen=run.past.maxlen)
    for number in range(plan.steps):
        drive = run.drive(y, number)
        after = np.where(run.free, plan.characteristic(drive), y)
        if sign:
            after = np.where(drive == 0, y, after)
        change = run.steepness(after - y)
        if settling and (change <= SETTLED_RATE or (number and np.array_equal(after, before))):
            return y, float(number), change <= SETTLED_RATE, change
        before, y = y, after
        run.past.append(y)
    return (y, float(plan.steps), False, change) if settling else (y, float(plan.duration), False, math.nan)


def _adaptive(plan: Plan, run: _Run) -> tuple[Array, float, bool, float]:
    from scipy.integrate import solve_ivp

    assert plan.duration != "settled"

    def rate(_t: float, flat: Array) -> Array:
        x = flat.reshape(run.x.shape)
        return np.where(run.free, (run.drive(x, 0) - x) * run.rates, 0.0).ravel()

    if run.wall:
        raise InputError("the adaptive scheme has no walls; full-range cells with terms take a fixed step")
    solution = solve_ivp(rate, (0.0, plan.duration), run.x.ravel(), method="DOP853", rtol=1e-10, atol=1e-12)
    if not solution.success:
        raise InputError(f"the adaptive scheme gave up at t = {solution.t[-1]:g}: {solution.message}")
    return solution.y[:, -1].reshape(run.x.shape), float(plan.duration), False, math.nan
