"""Point loads on a finger over time: a force that travels along a path of keyframes."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.loads import FORCE
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads, point_loads


def along_path(path: Floats, times: Floats) -> tuple[Floats, Flags]:
    """The path's columns (n, columns - 1) at the times [s], and where it is not there.

    Between its rows a path changes linearly; before the first and after the last it is not there. With one row it
    stands still from that time on.
    """
    rows = np.stack([np.interp(times, path[:, 0], column) for column in path[:, 1:].T], axis=-1)
    gone = times < path[0, 0]
    if len(path) > 1:
        gone |= times > path[-1, 0]
    return rows, gone


@dataclass(frozen=True)
class MovingLoad:
    """A point load on one finger: ``path`` (n, 6), rows (t, x, y, Q, R, F) [s, m, m, N, N, N], t growing."""

    finger: int
    path: Floats

    def at(self, times: Floats) -> Floats:
        """Return rows (x, y, Q, R, F) [m, N] at the times [s], without force where the load is absent."""
        rows, gone = along_path(self.path, times)
        rows[gone, FORCE] = 0
        return rows

    def loads(self, times: Floats, depth: float, medium: Medium) -> Loads:
        """The load on the finger at the times [s]."""
        return point_loads(self.at(times))
