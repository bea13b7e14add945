"""Point loads on a finger over time: a force that travels along a path of keyframes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Flags, Floats, InputError
from cnnsim.support.compiled_loops import kept_njit
from cnnsim.support.keywords import spelled
from tactile.core.loads import COLUMNS, FORCE
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.mounting import STILL, Rig, at_a_point


def along_path(path: Floats, times: Floats) -> tuple[Floats, Flags]:
    """The path's columns (n, columns - 1) at the times [s], and where it is not there.

    Between its rows a path changes linearly; before the first and after the last it is not there. With one row it
    stands still from that time on.
    """
    rows, gone = np.empty((len(times), path.shape[1] - 1)), np.empty(len(times), np.bool_)
    follow_path(np.ascontiguousarray(path), np.ascontiguousarray(times, np.float64), rows, gone)
    return rows, gone


@kept_njit()
def follow_path(path, times, rows, gone):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Put the columns at the times into ``rows``, each as `numpy.interp` has it, and where the path is not there."""
    last = path.shape[0] - 1
    for n in range(times.size):
        t, k = times[n], 0
        gone[n] = t < path[0, 0] or (last > 0 and t > path[last, 0])
        high = last
        while k < high:  # the last row that is not later
            middle = (k + high + 1) // 2
            if path[middle, 0] <= t:
                k = middle
            else:
                high = middle - 1
        if k == last or t <= path[k, 0]:
            for c in range(rows.shape[1]):  # by hand: an assignment of arrays takes seconds to compile
                rows[n, c] = path[k, c + 1]
            continue
        for c in range(rows.shape[1]):
            slope = (path[k + 1, c + 1] - path[k, c + 1]) / (path[k + 1, 0] - path[k, 0])
            rows[n, c] = slope * (t - path[k, 0]) + path[k, c + 1]


def path_array(path: ArrayLike) -> Floats:
    """Return a path as an array of floats, an empty one of what cannot be one."""
    try:
        return np.asarray(path, dtype=np.float64)
    except (TypeError, ValueError):
        return np.empty(0)


def checked_path(path: ArrayLike, columns: int, what: str) -> Floats:
    """Return a path as an array of rows, the first column of which is a growing time.

    Raises:
        InputError: no rows, rows of another length, numbers that are not finite, times that do not grow.
    """
    rows = path_array(path)
    if rows.ndim != 2 or not len(rows) or rows.shape[1] != columns or not np.isfinite(rows).all():
        raise InputError(f"path of a {what} of shape {rows.shape}; (keyframes, {columns}) finite numbers wanted")
    if (np.diff(rows[:, 0]) <= 0).any():
        raise InputError(f"path of a {what}: times {rows[:, 0].tolist()}; growing ones wanted")
    return rows


def span(path: Floats) -> str:
    """Return how many keyframes a path has and from when to when it goes, in words."""
    return f"{len(path)} keyframe{'s' * (len(path) != 1)} from {path[0, 0]:g} to {path[-1, 0]:g} s"


@dataclass(frozen=True, eq=False)  # arrays are not compared
class MovingLoad:
    """A point load on one finger, the one of that number in the scene's arrays.

    Arguments: ``path`` (n, 6), rows (t, x, y, Q, R, F) [s, m, m, N, N, N], an array or lists; between its rows all
    changes linearly, before the first and after the last there is no load.

    Raises:
        InputError: a path of another shape, with numbers that are not finite, or with times that do not grow.
    """

    finger: int
    path: Floats

    @spelled()
    def __init__(self, finger: int, path: ArrayLike) -> None:
        object.__setattr__(self, "finger", finger)
        object.__setattr__(self, "path", checked_path(path, 1 + COLUMNS, "load"))

    def __repr__(self) -> str:
        return f"MovingLoad(finger={self.finger}, {span(self.path)})"

    def at(self, times: Floats) -> Floats:
        """Return rows (x, y, Q, R, F) [m, N] at the times [s], without force where the load is absent."""
        rows, gone = along_path(self.path, times)
        rows[gone, FORCE] = 0
        return rows

    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        """The load on the finger at the times [s], as the rig holds it."""
        return at_a_point(self.at(times), medium, rig)
