"""Tare: the mean of the first frames, in which nothing touches the array, is subtracted from all that follow."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.core.frame import Frame


class Tare:
    """Subtracts the mean of one finger's first ``frames`` frames, during which nothing may touch it.

    Called with a frame, gives the frame less the mean. The frames that are still being averaged come back with no
    valid taxel. A taxel's invalid readings do not count; one without any valid reading stays invalid.

    Raises:
        InputError: a negative number of frames.
    """

    def __init__(self, frames: int) -> None:
        if frames < 0:
            raise InputError(f"tare over {frames} frames, 0 or more wanted")
        self._left = frames
        self._sum: Floats | float = 0.0
        self._count: Integers | int = 0
        self._offset: Floats | float = 0.0

    def __call__(self, frame: Frame) -> Frame:
        """Return the frame less the mean, or with no valid taxel while the mean is being made."""
        if self._left == 0:
            return self._tared(frame)
        usable = frame.valid & np.isfinite(frame.values).all(-1)
        self._sum = self._sum + np.where(usable[..., None], frame.values, 0.0)
        self._count = self._count + usable.astype(np.int64)
        self._left -= 1
        if self._left == 0:
            seen = np.asarray(self._count)[..., None]
            self._offset = np.where(seen > 0, self._sum / np.maximum(seen, 1), np.nan)
        return replace(frame, valid=np.zeros_like(frame.valid))

    def _tared(self, frame: Frame) -> Frame:
        values = frame.values - self._offset
        return replace(frame, values=values, valid=frame.valid & np.isfinite(values).all(-1))
