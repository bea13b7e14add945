"""Tare: the mean of the first frames, in which nothing touches the array, is subtracted from all that follow."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.calibration.gains import Gains
from tactile.calibration.tare_check import PARTS, TareCheck, check_tare
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import Frame, TaxelArray


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
        self._frames = self._left = frames
        self._sums: list[Floats] = []
        self._counts: list[Floats] = []
        self._times: list[float] = []
        self._offset: Floats | float = 0.0

    def __call__(self, frame: Frame) -> Frame:
        """Return the frame less the mean, or with no valid taxel while the mean is being made."""
        if self._left == 0:
            return self._tared(frame)
        usable = (frame.valid & np.isfinite(frame.values).all(-1))[..., None]
        part = PARTS * (self._frames - self._left) // self._frames
        if part >= len(self._sums) or not self._sums:
            self._sums.append(np.zeros_like(frame.values, dtype=np.float64))
            self._counts.append(np.zeros((*frame.valid.shape, 1)))
        self._sums[-1] += np.where(usable, frame.values, 0.0)
        self._counts[-1] += usable
        self._times.append(frame.t)
        self._left -= 1
        if self._left == 0:
            seen = np.sum(self._counts, axis=0)
            self._offset = np.where(seen > 0, np.sum(self._sums, axis=0) / np.maximum(seen, 1), np.nan)
        return replace(frame, valid=np.zeros_like(frame.valid))

    def _tared(self, frame: Frame) -> Frame:
        values = frame.values - self._offset
        return replace(frame, values=values, valid=frame.valid & np.isfinite(values).all(-1))

    def check(self, array: TaxelArray, gains: Gains | TaxelGains | None) -> TareCheck | None:
        """Return what the mean took away from an array, once: after the last of its frames, else None.

        ``gains``: what takes the readings to the array's quantity, None where they are in it.
        """
        if self._left or not self._sums:
            return None
        counts = np.array(self._counts)
        parts = np.where(counts > 0, np.array(self._sums) / np.maximum(counts, 1), np.nan)
        self._sums, self._counts = [], []
        seconds = self._times[-1] - self._times[0]
        return check_tare(array, parts if gains is None else gains(parts), self._frames, seconds)
