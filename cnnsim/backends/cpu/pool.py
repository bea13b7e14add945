"""Planes that a transient has done with, kept for the next one."""

import numpy as np

from cnnsim.support import Array

MOST = 2
"""Planes kept: the drive of a transient, and one of the two planes between which its steps go."""
WORTH_KEEPING = 1 << 20
"""Bytes of a plane from which memory that the system has to hand out anew costs more than a step of the time loop."""


class Pool:
    """At most ``MOST`` large planes of one shape that are in use no more."""

    def __init__(self) -> None:
        self._planes: list[Array] = []

    def plane(self, like: Array) -> Array:
        """Return a plane of the shape and type of another one, with anything in it."""
        while self._planes and like.nbytes >= WORTH_KEEPING:
            plane = self._planes.pop()
            if plane.shape == like.shape and plane.dtype == like.dtype:
                return plane
        return np.empty_like(like)

    def keep(self, *planes: Array) -> None:
        """Take planes that are in use no more."""
        self._planes += [plane for plane in planes if plane.nbytes >= WORTH_KEEPING]
        del self._planes[:-MOST]
