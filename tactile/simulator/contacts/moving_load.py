"""Point loads that move along a path of keyframes; functions for paths."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Flags, Floats, InputError
from cnnsim.support.keywords import spelled
from tactile.core.loads import COLUMNS, FORCE
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.mounting import STILL, Rig, at_a_point


def along_path(path: Floats, times: Floats) -> tuple[Floats, Flags]:
    """Return a path's columns (n, columns - 1) at the times [s], and whether it is absent then.

    Between its rows a path is linear; before the first and after the last it is absent. A path of one row stays there
    from its time on.
    """
    rows = np.empty((len(times), path.shape[1] - 1))
    for column, values in zip(rows.T, path[:, 1:].T, strict=True):
        column[:] = np.interp(times, path[:, 0], values)
    return rows, (times < path[0, 0]) | ((times > path[-1, 0]) & (len(path) > 1))


def path_array(path: ArrayLike) -> Floats:
    """Return a path as an array of floats, an empty one if it cannot be converted."""
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
    """Return a path's number of keyframes and time span in words."""
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
        """Return the load on the finger at the times [s], with the rig's moves."""
        return at_a_point(self.at(times), medium, rig)
