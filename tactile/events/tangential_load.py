"""Tangential load: the shear part of a finger's located load, compared with thresholds of force."""

from math import isfinite

import numpy as np

from cnnsim.program.machine import UniversalMachine
from tactile.events.code import CONTACT, SHEAR, encode_values
from tactile.events.comparators import Comparators
from tactile.events.detector import Observation
from tactile.events.event import EventKind, Happening


class LoadKind(EventKind):
    """Kinds of change of the tangential load: its ``direction``, and its size ``force_n`` [N] at that time."""

    TANGENTIAL_LOAD = "tangential load {direction}: {force_n:.2f} N"
    TANGENTIAL_LOAD_GONE = "tangential load gone"


class TangentialLoad:
    """Compares the located load's (Q, R, F) as if it were one taxel that measures force; NaN counts as 0 N."""

    def __init__(self, machine: UniversalMachine) -> None:
        self._comparators = Comparators(machine, (1, 1), SHEAR["force"], CONTACT["force"])

    def detect(self, seen: Observation) -> list[Happening]:
        """Return the new direction of the tangential load; nothing where only the normal part has changed."""
        load = seen.load
        if load is None:
            return []
        whole = np.array([[[part if isfinite(part) else 0.0 for part in (load.Q, load.R, load.F)]]])
        if not self._comparators.update(encode_values(whole, "force", SHEAR["force"], CONTACT["force"])):
            return []
        before, after = self._comparators.before, self._comparators.code
        if np.array_equal((before.x, before.y), (after.x, after.y)):
            return []
        if not (after.x.any() or after.y.any()):
            return [(LoadKind.TANGENTIAL_LOAD_GONE, {})]
        force = float(np.hypot(load.Q, load.R))
        return [(LoadKind.TANGENTIAL_LOAD, {"direction": after.direction(), "force_n": force})]
