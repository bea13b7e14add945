"""What drives a cell without a time loop: weighted sums over neighbours, and w = B*u + z with the bias map."""

from collections.abc import Sequence

import numpy as np

from cnnsim.backends.reference.terms import add_term
from cnnsim.network import Boundary, Tap, pad
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


def correlate(plane: Array, taps: Sequence[Tap], boundary: Boundary, constant: float, start: Array) -> Array:
    """Return start + sum over the taps of weight * plane(row + k, col + l), added in the order of the taps."""
    total = start.copy()
    r = max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)
    around = pad(plane, r, boundary, constant)
    rows, cols = plane.shape[-2:]
    for k, l, weight in taps:
        total += weight * around[..., r + k : r + k + rows, r + l : r + l + cols]
    return total


def control(plan: Plan, x: Array, u: Array | None, bias: Array | None) -> Array:
    """Return w = z + bias + terms of the input + B*u, of the shape of ``x``."""
    template, boundary = plan.template, plan.boundary
    if u is not None and template.control_terms:
        bias = np.zeros_like(u) if bias is None else bias.copy()
        for term in template.control_terms:
            add_term(bias, term, 0, lambda _quantity, _layer: u, boundary)
    w = np.full_like(x, template.z)
    if bias is not None:
        w += bias
    return w if u is None else correlate(u, template.control_taps, boundary, boundary.u, w)
