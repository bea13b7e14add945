"""The constant part of the drive: w = B*u + z with the bias map and the terms of the input."""

import numpy as np

from cnnsim.backends.reference.terms import add_term
from cnnsim.network.boundary import correlate
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


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
