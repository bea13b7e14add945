"""Arrangement of wire readings into frames of fingers, and the inverse for emulators."""

from collections.abc import Iterator

import numpy as np

from tactile.core.frame import Frame
from tactile.wire.description import Board, Description
from tactile.wire.reading import Reading, Taxels

NOTHING = np.full((1, 3), np.nan)
"""Reading of a cell without a chip."""


class Arrange:
    """Splits readings by board, turns axes, applies gains, and puts chips into cells.

    Frames without a sequence number of the device are counted from 0 for each finger.
    """

    def __init__(self, description: Description) -> None:
        self._boards = description.boards
        self._chips = [board.chips for board in self._boards]
        self._counts = [0] * len(self._boards)

    def __call__(self, reading: Reading, t: float) -> Iterator[Frame]:
        """Yield the frames of a reading taken at host time ``t`` [s]."""
        if reading.device is not None:
            yield self._frame(reading.device, reading.values, reading, t)
            return
        at = 0
        for finger, chips in enumerate(self._chips):
            yield self._frame(finger, reading.values[at : at + chips], reading, t)
            at += chips

    def _frame(self, finger: int, taxels: Taxels, reading: Reading, t: float) -> Frame:
        board = self._boards[finger]
        turned = taxels @ board.turn.T
        if board.gains is not None:
            turned = board.gains(turned)
        values = np.concatenate((turned, NOTHING))[board.cells]  # cell -1 is the row at the end
        valid = np.logical_and.reduce(np.isfinite(values), axis=-1)
        sequence = self._counts[finger] if reading.sequence is None else reading.sequence
        self._counts[finger] += 1
        return Frame(finger, t, sequence, values, valid, reading.t_device)


def back(frame: Frame, board: Board) -> Taxels:
    """Return (chips, 3): what a device would have read to give this frame."""
    values = np.empty((board.chips, 3))
    values[board.cells[board.cells >= 0]] = frame.values[board.cells >= 0]
    if board.gains is not None:
        values = values / [board.gains.shear, board.gains.shear, board.gains.normal]
    return values @ board.turn
