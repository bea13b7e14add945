"""Transients that only go one way: their end does not depend on the step, so it may be as long as a time constant.

Where no neighbour inhibits (A(k, l) >= 0 off the centre, and at it) and no output begins to rise, none ever rises: a
drive is then never larger than before. The outputs fall to the largest rest below the start. That holds for the flow
and for Euler's steps of h <= 1 alike, x <- (1 - h) x + h (A*y + w) being monotone as well, and so both have one end
(Hirsch and Smith, "Monotone Dynamical Systems", 2005, theorems 3.1 and 5.5). The same upside down.
"""

import numpy as np

from cnnsim.network.boundary import correlate
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags


def is_cooperative(plan: Plan) -> bool:
    """Return whether no neighbour, nor a cell itself, inhibits a cell of a linear template."""
    return plan.method == "stepped" and plan.cell in ("chua-yang", "full-range") and bool((plan.template.A >= 0).all())


def goes_one_way(plan: Plan, x: Array, drive: Array, mask: Flags | None) -> bool:
    """Return whether all outputs of a cooperative template begin to fall, or all to rise, or stay as they are.

    Arguments: the state, w = B*u + z + bias, and the cells that keep their state.
    """
    y = x.clip(-1, 1)
    rate = correlate(y, plan.template.feedback_taps, plan.boundary, plan.boundary.y, drive.copy()) - x
    free = np.ones(x.shape, bool) if mask is None else ~mask
    falls = (rate <= 0) | (x >= 1) | ~free
    rises = (rate >= 0) | (x <= -1) | ~free
    return bool(falls.all()) or bool(rises.all())
