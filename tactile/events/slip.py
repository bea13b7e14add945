"""Slip: a located load that travels over the skin while it presses."""

from dataclasses import dataclass
from math import hypot

from tactile.inverse.localise import Load
from tactile.inverse.validity import Validity

START = 50e-6
"""[m] of travel that begins a slip: ten times the precision of localisation (3-5 um, paper, section 4)."""
REST = 0.25
"""[s] without ``START`` of travel that ends one: longer than the sticking phases of stick-slip."""


@dataclass(frozen=True)
class Slip:
    """A change: slip begins, or ends after ``dx``, ``dy`` [m]."""

    begins: bool
    dx: float
    dy: float


class SlipWatch:
    """Follows one finger's located load from contact to release."""

    def __init__(self) -> None:
        self._mark: tuple[float, float, float] | None = None
        self._start: tuple[float, float] | None = None

    def update(self, t: float, load: Load, contact: bool) -> Slip | None:
        """Take the load at time ``t`` [s] and return a change, if there is one."""
        located = load.validity in (Validity.INSIDE, Validity.OUTSIDE) and load.taxels >= 3
        if not contact:
            ended = self._end() if self._start is not None else None
            self._mark = None
            return ended
        if not located:
            return None
        if self._mark is None:
            self._mark = (t, load.x, load.y)
            return None
        since, x, y = self._mark
        if hypot(load.x - x, load.y - y) > START:
            self._mark = (t, load.x, load.y)
            if self._start is None:
                self._start = (x, y)
                return Slip(True, load.x - x, load.y - y)
        elif t - since > REST and self._start is not None:
            return self._end()
        return None

    def _end(self) -> Slip:
        assert self._mark is not None
        assert self._start is not None
        (_, x, y), (x0, y0) = self._mark, self._start
        self._start = None
        return Slip(False, x - x0, y - y0)
