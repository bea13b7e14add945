"""Travel of a located load: whether it moves over the skin by more than its noise."""

from math import exp, hypot, isfinite

from tactile.inverse.load import Load
from tactile.inverse.validity import Validity

START = 50e-6
"""[m] Travel that begins a slip: ten times the precision of localisation (3-5 um, paper, section 4)."""
SIGMAS = 6.0
"""Least travel over the noise of the position from frame to frame, and over the uncertainty of both positions."""
REST = 0.25
"""[s] Time without such travel that ends a slip: longer than the sticking phases of stick-slip."""
MEMORY = 0.5
"""[s] Averaging time of the noise."""
FASTEST, JUMP = 0.5, 1e-3
"""[m/s], [m] A faster and longer jump between frames is another contact, not a slip."""
LOCATED = (Validity.INSIDE, Validity.OUTSIDE)


class Travel:
    """Follows the located load of one finger from contact to release; ``way`` (x, y) [m] is the path of its last slip.

    Of several loads it follows the nearest to the last position, not the strongest. The noise of the position is
    estimated from second differences, in which a steady motion vanishes.
    """

    def __init__(self) -> None:
        self._mark: tuple[float, float, float, float] | None = None
        self._last: list[tuple[float, float, float]] = []
        self._unrest = 0.0
        self._travels = False
        self._away = 0
        self._at: tuple[float, float, float] | None = None
        self._start = (0.0, 0.0)
        self.way = (0.0, 0.0)

    def update(self, t: float, load: Load, contact: bool) -> bool:
        """Return whether the load is moving."""
        if not contact:
            self._forget()
            return False
        load = self._followed(load)
        if load.validity not in LOCATED or load.taxels < 3:
            return self._travels
        if self._at is not None:
            before, x, y = self._at
            most = max(FASTEST * (t - before), JUMP, SIGMAS * self._unrest)
            if t > before and hypot(load.x - x, load.y - y) > most:
                self._forget()
        self._at = (t, load.x, load.y)
        self._learn(t, load)
        if self._mark is None:
            self._mark = (t, load.x, load.y, _spread(load))
            return False
        since, x, y, spread = self._mark
        # while a contact begins or ends the averaged noise is that of no grip or of a firmer one
        least = max(START, SIGMAS * self._unrest, SIGMAS * hypot(spread, _spread(load)))
        self._away = self._away + 1 if hypot(load.x - x, load.y - y) > least else 0
        # with noise a single reading is not enough
        if self._away >= (1 if self._unrest < START / SIGMAS else 3):
            self._mark, self._away = (t, load.x, load.y, _spread(load)), 0
            if not self._travels:
                self._start = (x, y)
            self.way = (load.x - self._start[0], load.y - self._start[1])
            self._travels = True
        elif t - since > REST:
            self._travels = False
        return self._travels

    def _forget(self) -> None:
        self._mark, self._at, self._travels, self._away = None, None, False, 0
        self._last.clear()

    def _followed(self, load: Load) -> Load:
        if self._at is None or not load.others:
            return load
        _, x, y = self._at
        located = [one for one in (load, *load.others) if one.validity in LOCATED] or [load]
        return min(located, key=lambda one: hypot(one.x - x, one.y - y))

    def _learn(self, t: float, load: Load) -> None:
        self._last.append((t, load.x, load.y))
        if len(self._last) < 3:
            return
        (t0, x0, y0), (_, x1, y1), (t2, x2, y2) = self._last
        self._last.pop(0)
        bend = hypot(x2 - 2 * x1 + x0, y2 - 2 * y1 + y0) / 3.46  # sqrt(6) sigma, two components
        weight = 1 - exp(-max(t2 - t0, 0.0) / 2 / MEMORY)  # a device's clock may jump back
        if bend < START or self._unrest > 0:  # a jump is not noise
            self._unrest = (self._unrest**2 * (1 - weight) + min(bend, START) ** 2 * weight) ** 0.5


def _spread(load: Load) -> float:
    """Return the standard deviation of a load's position [m] by noise, along its less certain axis; 0 if unknown.

    A misfit of the model shifts the position in all frames alike and does not count.
    """
    spread = max(load.scatter[:2])
    return spread if isfinite(spread) else 0.0
