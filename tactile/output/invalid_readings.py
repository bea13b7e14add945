"""Count of invalid readings: a run without events may be one without readings."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from cnnsim.support import Integers
from cnnsim.support.limits import READING
from tactile.core.frame import Frame, TaxelArray


@dataclass
class _Finger:
    """Counts of one finger: frames, frames without a reading, and invalid readings of each taxel."""

    unread: Integers
    frames: int = 0
    empty: int = 0
    partly: int = 0


@dataclass
class InvalidReadings:
    """Counts invalid taxels, and readings that are not finite or out of range, in frames as they come."""

    arrays: tuple[TaxelArray, ...]
    _fingers: list[_Finger] = field(init=False)

    def __post_init__(self) -> None:
        self._fingers = [_Finger(np.zeros(array.shape, np.int64)) for array in self.arrays]

    def through(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """Count the frames and pass them on."""
        for frame in frames:
            finger = self._fingers[frame.finger]
            finger.frames += 1
            read = frame.read
            if not (read is frame.valid and frame.whole):
                finger.unread += ~read
                finger.empty += not read.any()
                finger.partly += not read.all()
            yield frame

    @property
    def lines(self) -> list[str]:
        """One line per finger with invalid readings."""
        pairs = zip(self.arrays, self._fingers, strict=True)
        return [f"{array.name}: {said}" for array, finger in pairs if (said := _words(finger))]


def _words(finger: _Finger) -> str:
    if not finger.partly:
        return ""
    if finger.empty == finger.frames:
        return f"no taxel could be read in any of {finger.frames} frames (not valid, or no number up to {READING:g})"
    said, taxels = [], finger.unread.size
    never = int((finger.unread == finger.frames).sum())
    some = int(finger.unread[finger.unread < finger.frames].sum())
    if never:
        said.append(f"{never} of {taxels} taxels could be read in no frame")
    if some and never:
        said.append(f"{some} readings of other taxels could not be read")
    elif some:
        said.append(f"{some} readings of taxels in {finger.partly} of {finger.frames} frames could not be read")
    if finger.empty:
        said.append(f"in {finger.empty} frames none")
    return ", ".join(said)
