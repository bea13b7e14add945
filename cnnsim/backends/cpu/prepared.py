"""Plan constants converted to NumPy arrays for the loops: made at the first transient, kept as long as the plan."""

import math
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.jit.columns import tap_records
from cnnsim.backends.cpu.tiles.grid import Schedule
from cnnsim.backends.cpu.tiles.tiled import Tiled
from cnnsim.network import reach
from cnnsim.planning.plan import SETTLED_RATE, Plan


class Prepared:
    """Taps, virtual cells and numbers of one plan, in one dtype, for one number of threads; and its `Tiled` steps.

    Groups of parameters are bare tuples, in the order of the NamedTuple that names them: numba asks for the class of
    every NamedTuple that it is given, which takes 1.2 us.
    """

    def __init__(self, plan: Plan, dtype: np.dtype[Any], threads: int) -> None:
        template, boundary = plan.template, plan.boundary
        self.control = tap_records(template.control_taps, dtype)
        r = reach((tap.k, tap.l) for tap in template.control_taps)
        self.around_u = virtual_cells(plan.shape, r, boundary, dtype.type(boundary.u))
        self.z = dtype.type(template.z)
        self.settles, self.limited = plan.duration == "settled", plan.cell == "full-range"
        self.t = math.inf if plan.duration == "settled" else float(plan.duration)
        a = dtype.type(template.self_feedback) if self.settles else float(template.self_feedback)
        self.cell = a, self.t, self.limited
        if plan.scheme is None:
            return
        self.schedule = tuple(
            Schedule(plan.steps, plan.check_every if self.settles else 0, SETTLED_RATE, plan.saturation_ends)
        )
        self.is_euler = len(plan.scheme.b) == 1 and not self.limited
        self._for_tiles = plan, dtype, threads

    @cached_property
    def tiled(self) -> Tiled:
        """Return the steps by tiles of a grid of which no cell is held."""
        return Tiled(*self._for_tiles, masked=False)

    @cached_property
    def masked(self) -> Tiled:
        """Return the steps by tiles of a grid with a mask."""
        return Tiled(*self._for_tiles, masked=True)
