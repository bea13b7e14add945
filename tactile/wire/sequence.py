"""Sequence numbers of one board: repeated, missing and swapped frames, and numbers that stand still."""

from collections import deque
from dataclasses import replace

import numpy as np

from tactile.wire.reading import Counts, Reading

NEXT = 1024
"""Largest difference of sequence numbers that counts as lost frames: a second of frames."""
RECENT = 64
"""Number of missing frames per board that may still come."""
STILL = 16
"""Number of frames with one sequence number, those with other values twice, from which the number stands still."""
RANGE = 2**32


class SequenceCheck:
    """Counts by the sequence numbers of one board; a step back or of over half the range is a restarted device.

    A number that comes again is a repeated frame, unless its values differ or the number stands still: then
    ``still`` is true, and frames pass without their number.
    """

    def __init__(self, counts: Counts) -> None:
        self.still = False
        self._counts = counts
        self._last: Reading | None = None
        self._leapt: Reading | None = None  # a number that leapt in a frame without a checksum
        self._missing: deque[int] = deque(maxlen=RECENT)
        self._same = 0

    def __call__(self, reading: Reading) -> Reading | None:
        """Return the reading if it is new."""
        number = reading.sequence
        if number is None or self._last is None:
            self._last = self._last if number is None else reading
            return reading
        for known in (self._last, self._leapt):
            if known is not None and number == known.sequence:
                return self._again(reading, known)
        self._same, self.still = 0, False
        step = self._ahead(number, self._last)
        if number in self._missing:
            self._missing.remove(number)
            self._counts.missing -= 1
        elif step == 1 or reading.checked:
            self._believe(reading, step)
        else:
            self._weigh(reading, step)
        return reading

    def _again(self, reading: Reading, known: Reading) -> Reading | None:
        differs = not np.array_equal(reading.values, known.values, equal_nan=True)
        self._same += 1 + differs
        self.still = self._same >= STILL
        if not differs and not self.still:
            self._counts.repeated += 1
            return None
        if known is self._last:
            self._last = reading
        return replace(reading, sequence=None) if self.still else reading

    def _weigh(self, reading: Reading, step: int) -> None:
        """Accept a jump of an unprotected sequence number when the next frame continues from it.

        If the next frame continues from the number before, the jump was a corrupted number.
        """
        doubted = self._leapt
        if doubted is not None and step < NEXT:
            self._believe(reading, step, doubted)
        elif doubted is not None and (onward := self._ahead(reading.sequence, doubted)) < NEXT:
            self._believe(doubted, self._ahead(doubted.sequence, self._last))
            self._believe(reading, onward)
        else:
            self._leapt = reading

    def _believe(self, reading: Reading, step: int, doubted: Reading | None = None) -> None:
        """Count the frames between the last number and that of ``reading``, of which ``doubted`` was one."""
        early, self._leapt, self._last = self._leapt, None, reading
        assert reading.sequence is not None
        if step >= RANGE // 2:
            self._missing.clear()
            return
        between = [(reading.sequence - back) % RANGE for back in range(min(step - 1, RECENT), 0, -1)]
        if doubted is not None and between:
            between.remove(doubted.sequence if doubted.sequence in between else between[0])
        self._counts.missing += step - 1 - (doubted is not None)
        self._missing.extend(between)
        if step == 1 and early is not None and (onward := self._ahead(early.sequence, reading)) < RECENT:
            self._believe(early, onward)  # it came before its neighbour

    @staticmethod
    def _ahead(number: int | None, last: Reading | None) -> int:
        assert number is not None
        assert last is not None
        assert last.sequence is not None
        return (number - last.sequence) % RANGE
