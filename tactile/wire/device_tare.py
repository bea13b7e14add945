"""Tare inside an emulated device: the mean of some readings, subtracted on request of the host."""

from collections.abc import Sequence

import numpy as np

from tactile.wire.reading import Taxels


class DeviceTare:
    """Subtracts the mean of the readings of ``seconds`` after `ask`, from the end of that time to the next request."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._asked = False
        self._until: float | None = None
        self._seen: list[list[Taxels]] = []
        self._offset: list[Taxels] | None = None

    def ask(self) -> None:
        """Start to average with the next readings."""
        self._asked, self._until, self._seen = True, None, []

    def __call__(self, boards: Sequence[Taxels], t: float) -> list[Taxels]:
        """Return the readings of all boards at device time ``t`` [s] minus the offset."""
        if self._asked:
            self._asked, self._until = False, t + self._seconds
        if self._until is not None:
            self._seen.append(list(boards))
            if t >= self._until:
                self._offset = [np.mean(board, axis=0) for board in zip(*self._seen, strict=True)]
                self._until, self._seen = None, []
        if self._offset is None:
            return list(boards)
        return [board - offset for board, offset in zip(boards, self._offset, strict=True)]
