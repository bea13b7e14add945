"""Planes that a transient has done with, kept for the next one."""

import numpy as np

from cnnsim.support import Array

MOST = 3
"""Planes kept: the drive of a transient, and the two planes between which its steps go; its end often is one of them,
and comes back where blocks of a large grid are stepped."""
ROOMY = 1.5
"""A plane may lie in memory that is so many times larger: blocks at an edge are smaller than others by their halo."""
WORTH_KEEPING = 1 << 20
"""Bytes of a plane from which memory that the system has to hand out anew costs more than a step of the time loop."""


class Pool:
    """The memory of at most ``MOST`` large planes that are in use no more."""

    def __init__(self) -> None:
        self._kept: list[Array] = []

    def plane(self, like: Array) -> Array:
        """Return a plane of the shape and type of another one, with anything in it."""
        while self._kept and like.nbytes >= WORTH_KEEPING:
            flat = self._kept.pop()
            if flat.dtype == like.dtype and like.size <= flat.size <= ROOMY * like.size:
                return flat[: like.size].reshape(like.shape)
        return np.empty_like(like)

    def keep(self, *planes: Array) -> None:
        """Take planes that are in use no more."""
        self._kept += [_whole(plane) for plane in planes if plane.nbytes >= WORTH_KEEPING]
        del self._kept[:-MOST]


def _whole(plane: Array) -> Array:
    """Return all the memory that a plane lies in, if NumPy made it for planes."""
    base = plane
    while isinstance(base.base, np.ndarray):
        base = base.base
    return base.reshape(-1) if base.dtype == plane.dtype and base.flags.c_contiguous and base.flags.owndata else plane
