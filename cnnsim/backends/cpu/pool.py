"""Memory of planes that a transient no longer needs, kept for the next one."""

import numpy as np

from cnnsim.support import Array

MOST = 3
"""Planes kept: the drive of a transient, and the two planes between which its steps alternate."""
WORTH_KEEPING = 1 << 20
"""Bytes of a plane from which fresh memory of the system costs more than a step of the time loop."""


class Pool:
    """At most `MOST` large planes that are free."""

    def __init__(self) -> None:
        self._kept: list[Array] = []

    def plane(self, like: Array) -> Array:
        """Return a plane of the shape and type of another one, with any contents."""
        while self._kept and like.nbytes >= WORTH_KEEPING:
            plane = self._kept.pop()
            if plane.dtype == like.dtype and plane.size == like.size:
                return plane.reshape(like.shape)
        return np.empty_like(like)

    def keep(self, *planes: Array) -> None:
        """Take planes that are free."""
        self._kept += [plane for plane in planes if plane.nbytes >= WORTH_KEEPING]
        del self._kept[:-MOST]
