"""Slip events: a located load that travels over the skin while it presses (`pipeline.run` makes the `Event`)."""

from math import hypot

import numpy as np

from tactile.events.detector import Observation
from tactile.events.event import EventKind, Happening
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity

START = 50e-6
"""[m] of travel that begins a slip: ten times the precision of localisation (3-5 um, paper, section 4)."""
REST = 0.25
"""[s] without ``START`` of travel that ends one: longer than the sticking phases of stick-slip."""


class SlipKind(EventKind):
    """A slip begins or ends, after a travel of ``dx_m``, ``dy_m`` [m] mainly in ``direction``."""

    SLIP_BEGINS = "slip begins toward {direction}"
    SLIP_ENDS = "slip ends: {length_mm:.2f} mm toward {direction}"


class SlipDetector:
    """Follows one finger's located load from contact to release."""

    def __init__(self) -> None:
        self._mark: tuple[float, float, float] | None = None
        self._start: tuple[float, float] | None = None

    def detect(self, seen: Observation) -> list[Happening]:
        """Return the beginning or the end of a slip."""
        return [] if seen.load is None else self._follow(seen.frame.t, seen.load, bool(seen.code.contact.any()))

    def _follow(self, t: float, load: Load, contact: bool) -> list[Happening]:
        located = load.validity in (Validity.INSIDE, Validity.OUTSIDE) and load.taxels >= 3
        if not contact:
            ended = [] if self._start is None else [self._end()]
            self._mark = None
            return ended
        if not located:
            return []
        if self._mark is None:
            self._mark = (t, load.x, load.y)
            return []
        since, x, y = self._mark
        if hypot(load.x - x, load.y - y) > START:
            self._mark = (t, load.x, load.y)
            if self._start is None:
                self._start = (x, y)
                return [_travel(SlipKind.SLIP_BEGINS, load.x - x, load.y - y)]
        elif t - since > REST and self._start is not None:
            return [self._end()]
        return []

    def _end(self) -> Happening:
        assert self._mark is not None
        assert self._start is not None
        (_, x, y), (x0, y0) = self._mark, self._start
        self._start = None
        return _travel(SlipKind.SLIP_ENDS, x - x0, y - y0)


def _travel(kind: SlipKind, dx: float, dy: float) -> Happening:
    along_y = abs(dy) >= abs(dx)
    direction = ("-" if (dy if along_y else dx) < 0 else "+") + ("y" if along_y else "x")
    return kind, {"direction": direction, "length_m": float(np.hypot(dx, dy)), "dx_m": dx, "dy_m": dy}
