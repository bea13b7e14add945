"""Tare of arriving frames: renewed at the start, on request, and by itself while nothing touches; not under load."""

from dataclasses import dataclass, replace

import numpy as np

from cnnsim.support import Floats
from tactile.calibration.gains import Gains
from tactile.calibration.tare_check import check_tare, measure
from tactile.core.frame import NORMAL, Frame, TaxelArray
from tactile.events.code import CONTACT, SHEAR

BLOCK = 100
"""Frames whose mean is taken together."""
IDLE = "idle"
"""Why an offset was renewed that nobody asked for."""
CURE = "let nothing touch it, then ask for a tare"


@dataclass(frozen=True)
class TareNote:
    """What became of a block: ``offset`` (rows, cols, 3) where it was taken, else None and ``why`` in words.

    ``detail``: how much was taken away, or what was wrong and what to do; empty for renewals while idle.
    """

    finger: int
    t: float
    why: str
    offset: Floats | None
    detail: str = ""


class LiveTare:
    """Subtracts an offset from one finger's frames and renews it from blocks of frames that are still and unloaded.

    Still: no component moves by more than the dead band within the block. Unloaded: the block's mean is within half a
    dead band of the offset on every taxel. The first block only has to be still, since there is nothing yet to tell a
    load by: let nothing touch the array then. A load that grows by less than half a dead band per block, the slowest of
    all, is taken for drift.

    Until there is an offset no taxel is valid. ``automatic`` False renews on request only. ``gains``: what takes the
    readings to the array's quantity, in which the dead bands are; None where they are in it.
    """

    def __init__(
        self, finger: int, array: TaxelArray, automatic: bool = True, block: int = BLOCK, gains: Gains | None = None
    ) -> None:
        self.notes: list[TareNote] = []
        self._finger, self._automatic, self._block = finger, automatic, block
        self._array, self._gains = array, gains
        self._limit = np.full(3, SHEAR[array.quantity].dead_band)
        self._limit[NORMAL] = CONTACT[array.quantity].dead_band
        if gains is not None:
            self._limit /= np.abs(gains(np.ones(3)))
        self._offset: Floats | None = None
        self._asked = False
        self._begin()

    def _begin(self) -> None:
        self._count = 0
        self._sum: Floats | float = 0.0
        self._low: Floats | float = np.inf
        self._high: Floats | float = -np.inf

    def ask(self) -> None:
        """Renew the offset from the next block, if that is unloaded."""
        self._asked = True
        self._begin()

    def __call__(self, frame: Frame) -> Frame:
        """Return the frame less the offset."""
        values = np.where(frame.valid[..., None], frame.values, np.nan)
        self._sum, self._count = self._sum + values, self._count + 1
        self._low, self._high = np.minimum(self._low, values), np.maximum(self._high, values)
        if self._count == self._block:
            self._end_block(frame.t)
            self._begin()
        if self._offset is None:
            return replace(frame, valid=np.zeros_like(frame.valid))
        tared = frame.values - self._offset
        return replace(frame, values=tared, valid=frame.valid & np.isfinite(tared).all(-1))

    def _end_block(self, t: float) -> None:
        mean = np.asarray(self._sum) / self._count
        still = not (np.asarray(self._high) - self._low > self._limit).any()  # a taxel without readings is still
        loaded = self._offset is not None and bool((np.abs(mean - self._offset) > self._limit / 2).any())
        first, asked = self._offset is None, self._asked
        if not still or loaded:
            if asked or first:
                self._note(t, "refused: " + ("loaded" if loaded else "not still"), None, self._fault(mean, loaded))
            self._asked = False
            return
        if first or asked or self._automatic:
            self._asked = False
            before = self._offset
            # a taxel that was silent during this block keeps what it had
            self._offset = mean if before is None else np.where(np.isfinite(mean), mean, before)
            why = "at the start" if first else "on request" if asked else IDLE
            self._note(t, why, self._offset, self._taken(mean) if first or asked else "")

    def _taken(self, mean: Floats) -> str:
        """Say how much was taken away, and whether that looks like a load."""
        check = check_tare(self._array, self._in_quantity(mean)[None], self._block, 0.0)
        said = f"{check.amount} taken away"
        return f"{said}; loaded, or an offset of that size: {CURE}" if check.loaded else said

    def _fault(self, mean: Floats, loaded: bool) -> str:
        """Say by how much the block is loaded or moving."""
        if loaded:
            check = check_tare(self._array, self._in_quantity(mean - np.asarray(self._offset))[None], self._block, 0.0)
            return f"{check.amount} off the tare: {CURE}"
        moves = np.abs(self._in_quantity(np.nan_to_num(np.asarray(self._high) - self._low)))
        at = np.unravel_index((moves / np.abs(self._in_quantity(self._limit))).argmax(), moves.shape)
        return f"a taxel moves by {measure(float(moves[at]), self._array.quantity)}: {CURE}"

    def _in_quantity(self, readings: Floats) -> Floats:
        return readings if self._gains is None else self._gains(readings)

    def _note(self, t: float, why: str, offset: Floats | None, detail: str) -> None:
        self.notes.append(TareNote(self._finger, t, why, offset, detail))
