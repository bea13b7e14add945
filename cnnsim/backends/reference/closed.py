"""The closed form of cells without neighbours."""

import math

import numpy as np

from cnnsim.backends.base import Outcome
from cnnsim.network.cell import uncoupled_state
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


def closed_form(plan: Plan, x: Array, w: Array, free: Array) -> Outcome:
    """Return the state of uncoupled cells after the plan's duration, or their steady state."""
    settled = plan.duration == "settled"
    t = math.inf if settled else float(plan.duration)
    end = uncoupled_state(x, w, plan.template.self_feedback, t, plan.cell)
    return Outcome(np.where(free, end, x), t, settled, 0.0 if settled else math.nan)
