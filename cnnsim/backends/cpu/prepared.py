"""Constants of a plan as the compiled loops take them: made at the first transient, kept as long as the plan."""

import math
from typing import Any

import numpy as np

from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.compiled import tap_records
from cnnsim.backends.cpu.tiles.euler import EulerTiles
from cnnsim.network import reach
from cnnsim.planning.plan import Plan


class Prepared:
    """Taps, virtual cells and numbers of one plan, in one dtype, for one number of threads."""

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        template, boundary = plan.template, plan.boundary
        self.control = tap_records(template.control_taps, dtype)
        r = reach((tap.k, tap.l) for tap in template.control_taps)
        self.around_u = virtual_cells(plan.shape, r, boundary, dtype.type(boundary.u))
        self.z = dtype.type(template.z)
        self.settles, limited = plan.duration == "settled", plan.cell == "full-range"
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        a = dtype.type(template.self_feedback) if self.settles else float(template.self_feedback)
        self.cell = a, self.t, limited
        self.fuses = plan.scheme is not None and len(plan.scheme.b) == 1 and not limited
        self._dtype, self._threads = dtype, threads
        self._euler: EulerTiles | None = None

    def euler(self, plan: Plan) -> EulerTiles:
        """Return the Euler steps by tiles. The plan is not kept, so that its constants go with it."""
        if self._euler is None:
            self._euler = EulerTiles(plan, self._dtype, self._threads)
        return self._euler
