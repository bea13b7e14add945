"""Travel of a located load over the skin: whether it leaves the place where it rested, by more than its own unrest."""

from math import exp, hypot, isfinite

from tactile.inverse.load import Load
from tactile.inverse.validity import Validity

START = 50e-6
"""[m] of travel that begins a slip: ten times the precision of localisation (3-5 um, paper, section 4) ..."""
SIGMAS = 6.0
"""... and at least so many times the unrest of the place from frame to frame, and what both places are uncertain by."""
REST = 0.25
"""[s] without so much travel that ends one: longer than the sticking phases of stick-slip."""
MEMORY = 0.5
"""[s] over which the unrest is averaged."""
FASTEST, JUMP = 0.5, 1e-3
"""[m/s], [m] A place that is left faster, and as far, from frame to frame is no slip: another contact is located."""
LOCATED = (Validity.INSIDE, Validity.OUTSIDE)


class Travel:
    """Follows one finger's located load from contact to release; ``way`` (x, y) [m] that it went in its last slip.

    Of several loads it is the one nearest to where it was, and not the strongest, which another may become.
    The unrest is that of second differences, which a steady motion does not have.
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
        """Return whether the load travels."""
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
        # where little presses, as a contact begins or ends, the unrest is not yet known, or that of a firmer grip
        least = max(START, SIGMAS * self._unrest, SIGMAS * hypot(spread, _spread(load)))
        self._away = self._away + 1 if hypot(load.x - x, load.y - y) > least else 0
        # with noise one reading proves little
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
        bend = hypot(x2 - 2 * x1 + x0, y2 - 2 * y1 + y0) / 3.46  # of two independent components, over three readings
        weight = 1 - exp(-max(t2 - t0, 0.0) / 2 / MEMORY)  # a device's clock may jump back
        if bend < START or self._unrest > 0:  # a jump is no noise
            self._unrest = (self._unrest**2 * (1 - weight) + min(bend, START) ** 2 * weight) ** 0.5


def _spread(load: Load) -> float:
    """Return by how much a load's place [m] changes by chance, along the axis known less; 0 where nobody knows it.

    What the load leaves unexplained shifts the place in all frames alike, and is no part of it.
    """
    spread = max(load.scatter[:2])
    return spread if isfinite(spread) else 0.0
