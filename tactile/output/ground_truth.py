"""Ground truth of a scene: the true load of every frame, and the error of the located one."""

from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import FORCE, PLACE
from tactile.pipeline import FrameReport

AT_ONCE = 512
"""Frames per evaluation of the true loads."""
NAN = float("nan")


class TrueLoad(NamedTuple):
    """The true load of a frame: (x, y) [m], (Q, R, F) [N], NaN without one, and the errors of the located load.

    ``pressing``: number of loads at that time; the one nearest to the located position is given, or the strongest one.
    ``error_m``: distance of the positions; ``error_n``: length of the difference of the forces, of the located
    components; NaN if either load is missing.
    """

    pressing: int = 0
    x: float = NAN
    y: float = NAN
    Q: float = NAN
    R: float = NAN
    F: float = NAN
    error_m: float = NAN
    error_n: float = NAN


class GroundTruth:
    """Returns the true load of every report of a run on a scene, or on any source with ``loads_at``."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._known: dict[int, tuple[int, Floats]] = {}
        self._fingers = {array.name: number for number, array in enumerate(scene.arrays)}

    def __call__(self, report: FrameReport) -> TrueLoad:
        """Return the true load at the sampling time of a frame, from its sequence number."""
        rows = self._rows(self._fingers[report.array.name], report.frame.sequence)
        rows = rows[np.abs(rows[:, FORCE]).max(axis=1, initial=0.0) > 0]
        if not len(rows):
            return TrueLoad()
        load = report.load
        if load is None or not np.isfinite(load.x):
            return TrueLoad(len(rows), *rows[np.linalg.norm(rows[:, FORCE], axis=1).argmax()].tolist())
        apart = np.hypot(*(rows[:, PLACE] - (load.x, load.y)).T)
        true = rows[apart.argmin()]
        off = np.array((load.Q, load.R, load.F)) - true[FORCE]
        known = np.isfinite(off)
        error = float(np.linalg.norm(off[known])) if known.any() else NAN
        found = TrueLoad(len(rows), *true.tolist())
        return found._replace(error_m=float(apart.min()), error_n=error)

    def _rows(self, finger: int, sequence: int) -> Floats:
        """Return the (contacts, 5) loads on a finger at the sampling time of a frame."""
        first, loads = self._known.get(finger, (0, np.empty((0, 0, 5))))
        if not first <= sequence < first + len(loads):
            first = sequence - sequence % AT_ONCE
            loads = self._scene.loads_at(finger, np.arange(first, first + AT_ONCE) / self._scene.rate)
            self._known[finger] = first, loads
        rows: Floats = loads[sequence - first]
        return rows


def truth_of(source: Any) -> GroundTruth | None:
    """Return the ground truth of a scene; None for recordings."""
    return GroundTruth(source) if hasattr(source, "loads_at") else None
