"""Check whether a network has settled: its largest |dx/dt|, and whether every cell is saturated for good."""

import numpy as np

from cnnsim.backends.base import Check
from cnnsim.network.cell import rate
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


def check(plan: Plan, x: Array, drive: Array, free: Array) -> Check:
    """Check a state whose drive is A*y + w; ``free`` marks the cells that no mask holds."""
    largest = float(np.abs(rate(drive, x, plan.cell)[free]).max(initial=0.0))
    saturated = (np.abs(x) >= 1) & (np.sign(x) * drive >= 1)
    return Check(largest, plan.saturation_ends and bool(saturated[free].all()))
