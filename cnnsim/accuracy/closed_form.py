"""Uncoupled cells by their closed form: which of them rounding, or the last digit of an input, decides."""

import math
from dataclasses import replace

import numpy as np

from cnnsim.accuracy.repeatable import Reached, Repeatable, largest
from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.support import Array, Floats


def by_closed_form(transient: Repeatable, where: Backend, jumps: Floats | None) -> Reached:
    """Return the exact end of uncoupled cells; ``jumps`` by which their drives change with the last digit of an input.

    What rounding has added grows with the state, and with exp((a - 1) t) while a cell is linear. At its rest a cell
    with a > 1 has the sign of w + (a - 1) y(0), others that of w, so a drive that jumps decides where it is larger.
    """
    found = transient.once(where, "each cell has an exact solution")
    plan, (state, u, bias, mask) = transient.plan, transient.planes
    a, eps = plan.template.self_feedback, float(np.finfo(where.dtype).eps)
    size = max(1.0, largest(found.x))
    y: Array = plan.output(found.x)
    start: Array = np.ones(state.shape)  # where a <= 1 a run of a given time forgets its start
    if a > 1 or plan.duration == "settled":
        at_rest = plan.duration == "settled" and plan.cell == "chua-yang"
        start = found.x - a * y if at_rest else control(plan, state, u, bias)
        if a > 1:
            start += (a - 1) * np.clip(state, -1, 1)
        np.abs(start, out=start)
    unsure = start <= 4 * eps * size
    if a <= 1:
        unsure &= start > 0  # what adds up to 0 without rounding is 0
    elif plan.duration == "settled":
        unsure |= np.abs(y) < 1
    if jumps is not None:
        told = jumps > 0
        unsure |= told & (start <= jumps) if plan.duration == "settled" else told
    if mask is not None:
        unsure &= ~mask
    error = 4 * eps * size
    if plan.duration != "settled" and a > 1 and float(np.abs(y).min()) < 1:
        error *= math.exp((a - 1) * min(found.t, 40.0))
    return replace(found, error=error, undecided=unsure)
