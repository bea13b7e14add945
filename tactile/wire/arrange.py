"""Arrangement of wire readings into frames of fingers, and the inverse for emulators."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from cnnsim.support import Flags, Floats, Integers
from tactile.core.frame import Frame
from tactile.wire.description import Board, Description
from tactile.wire.reading import Reading, Taxels


class Arrange:
    """Splits readings by board, turns axes, applies gains, and puts chips into cells.

    Frames without a sequence number of the device are counted from 0 for each finger.
    """

    def __init__(self, description: Description) -> None:
        self._boards = description.boards
        self._places = [_places(board) for board in self._boards]
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
        place, factor = self._places[finger]
        numbers = np.empty(taxels.size + 1)
        numbers[:-1], numbers[-1] = taxels.ravel(), np.nan  # the last is that of a cell without a chip
        values: Floats = numbers[place]
        values *= factor
        finite = isfinite(np.vdot(values, values))
        valid: Flags = np.ones(place.shape[:2], bool)
        if not finite:
            valid = np.logical_and.reduce(np.isfinite(values), axis=-1)
        sequence = self._counts[finger] if reading.sequence is None else reading.sequence
        self._counts[finger] += 1
        return Frame(finger, t, sequence, values, valid, reading.t_device)


def _places(board: Board) -> tuple[Integers, Floats]:
    """Return where in the readings of a board the numbers (rows, cols, 3) of a frame are, -1 for none, and factors."""
    axes = board.turn.shape[1]
    place = board.cells[..., None] * axes + np.abs(board.turn).argmax(axis=1)
    factor = board.turn.sum(axis=1)
    return np.where(board.cells[..., None] < 0, -1, place), factor if board.gains is None else board.gains(factor)


def back(frame: Frame, board: Board) -> Taxels:
    """Return (chips, 3): what a device would have read to give this frame."""
    values = np.empty((board.chips, 3))
    values[board.cells[board.cells >= 0]] = frame.values[board.cells >= 0]
    if board.gains is not None:
        values = values / [board.gains.shear, board.gains.shear, board.gains.normal]
    return values @ board.turn
