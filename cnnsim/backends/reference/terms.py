"""Drives of networks of terms: layers, delays and sequences, one neighbour of one term at a time.

Planes are (n, layers, rows, cols).
"""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from cnnsim.backends.term_table import longest_delay
from cnnsim.network import Argument, Boundary, Frames, Quantity, Term, pad
from cnnsim.network.frames import at_step
from cnnsim.planning.plan import Plan
from cnnsim.support import Array

Lookup = Callable[[Quantity, int], Array]
"""Values that a term reads at its time: (quantity, layer) -> (n, rows, cols)."""


def add_term(total: Array, term: Term, own: int, lookup: Lookup, boundary: Boundary) -> None:
    """Add one term to the drive (n, rows, cols) of layer ``own``."""
    if not term.taps:  # it may read an input that is not given
        return
    rows, cols = total.shape[-2:]
    r = term.radius
    other = own if term.layer is None else term.layer

    def seen(argument: Argument) -> tuple[Array, Array | None]:
        """Return the padded plane of an argument's neighbours, and the plane that is subtracted, or None."""
        constant = boundary.u if argument.neighbour == "u" else boundary.y
        around = pad(lookup(argument.neighbour, other), r, boundary, constant)
        return around, None if argument.centre is None else lookup(argument.centre, own)

    def value(plane: tuple[Array, Array | None], k: int, l: int) -> Array:
        around, centre = plane
        there = around[..., r + k : r + k + rows, r + l : r + l + cols]
        return there if centre is None else there - centre

    of, times = seen(term.of), None if term.times is None else seen(term.times)
    for k, l, weight in term.taps:
        v = value(of, k, l)
        f = v if term.table is None else term.table(v)
        total += weight * (f if times is None else f * value(times, k, l))


class ReferenceNetwork:
    """The planes of a run, its past states and the drive of each layer; ``u`` and ``bias`` may be `Frames`."""

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, mask: Array | None) -> None:
        assert plan.network is not None
        self.plan, self.layers = plan, plan.network.layers
        self.shape = (-1, len(self.layers), *x.shape[-2:])
        self.x = x.reshape(self.shape)
        self.u, self.bias = self._planes(u), self._planes(bias)
        self.free = np.ones(self.x.shape, dtype=bool) if mask is None else ~mask.reshape(self.shape)
        self.past: deque[Array] = deque([self.x], maxlen=1 + longest_delay(plan, plan.network))
        self.rates = 1 / np.array(plan.network.time_constants).reshape(-1, 1, 1)
        self.terms = [
            (Term(layer.B, "u_kl"), *layer.control_terms, Term(layer.A, "y_kl"), *layer.feedback_terms)
            for layer in self.layers
        ]
        self.work = self.x.size * sum(len(term.taps) for terms in self.terms for term in terms)

    def _planes(self, value: Any) -> Any:
        if value is None:
            return None
        return value.map(self._planes) if isinstance(value, Frames) else value.reshape(self.shape)

    def drive(self, now: Array, number: int, ahead: int = 0) -> Array:
        """Return all layers' drives in state ``now``, ``ahead`` (0 or 1) steps from the start of step ``number``."""
        total = np.empty_like(now)
        for index, layer in enumerate(self.layers):
            part = np.full_like(now[:, 0], layer.z)
            if self.bias is not None:
                part += at_step(self.bias, number, self.plan.step)[:, index]
            for term in self.terms[index]:
                add_term(part, term, index, self._lookup(now, number, ahead, term.delay), self.plan.boundary)
            total[:, index] = part
        return total

    def _lookup(self, now: Array, number: int, ahead: int, delay: float) -> Lookup:
        ago = round(delay / self.plan.step)
        # A step reads the input of its start; before t = 0 the state was x(0) and the input the first.
        state = now if not ago else self.past[max(-len(self.past), ahead - 1 - ago)]

        def seen(quantity: Quantity, layer: int) -> Array:
            if quantity == "u":
                return at_step(self.u, number - ago, self.plan.step)[:, layer]
            return (state if quantity == "x" else self.plan.output(state))[:, layer]

        return seen

    def largest(self, values: Array) -> float:
        """Return the largest modulus in the free cells."""
        return float(np.abs(values[self.free]).max(initial=0.0))
