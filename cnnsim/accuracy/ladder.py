"""Runs of one transient by shorter and shorter steps, until two of them agree to the accuracy that is wanted.

The classical Runge-Kutta scheme is taken, because of those there are it reaches every accuracy with the least work
(docs/accuracy.md). Its order lies between 4, where nothing saturates, and 2, where the kinks of the characteristic
decide; which it is here, the runs themselves tell.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cnnsim.accuracy.wanted import Wanted
from cnnsim.support import Array, Flags

FIRST_STEP = 0.8
_FEWER = 0.7
"""Of the step that the runs so far promise, so that it is not missed by a little."""
_LOWEST, _HIGHEST = 1.0, 4.5
"""Orders that a run may show."""
_MOST_RUNS = 14
_SMOOTH = 3.2
"""From this order on steps are shortened by little, so that order 2 gives the error to a factor of ten."""
_SAFE = 0.25
"""Of the accuracy that the estimate may be: of 50 random transients two missed it with 0.5."""


@dataclass
class Ladder:
    """Ends of a transient for one step after another.

    ``run`` (step) -> state; ``output`` of a state; ``longest`` step that is stable; ``divides``: steps must divide
    ``longest`` by a power of two (of delays and sequences).
    """

    run: Callable[[float], Array]
    output: Callable[[Array], Array]
    longest: float
    divides: bool
    floor: float
    steps: list[float] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)
    differences: list[float] = field(default_factory=list)

    def climb(self, wanted: Wanted) -> tuple[float, Flags, bool]:
        """Take runs until one is as wanted; return its error, which cells it cannot vouch for, and whether it is."""
        first = min(FIRST_STEP, self.longest)
        for part in (1.0, 0.5, 0.25):  # two that agree by chance, far from the truth, are found out by a third
            self._take(self._fit(first * part))
        while True:
            error = self.error()
            unsure = self._unsure(error)
            if not unsure.any() if wanted.signs else error <= _SAFE * wanted.error:
                return error, unsure, True
            if len(self.steps) >= _MOST_RUNS or (error <= 4 * self.floor and not wanted.signs):
                return error, unsure, False
            goal = wanted.error if not wanted.signs else error / 16
            if wanted.signs and len(self.steps) >= 6:
                return error, unsure, False
            shrink = _FEWER * (goal / error) ** (1 / self.order())
            self._take(
                self._fit(self.steps[-1] * float(np.clip(shrink, 1 / 16 if self.order() < _SMOOTH else 1 / 3, 2 / 3)))
            )

    def order(self) -> float:
        """The order that the last three runs show; 1 where they do not come together as they should."""
        if not 0 < self.differences[-1] < self.differences[-2]:
            return 1.0 if self.differences[-1] else _HIGHEST
        (a, b, c), ratio = self.steps[-3:], self.differences[-2] / self.differences[-1]
        orders = np.linspace(_LOWEST, _HIGHEST, 61)
        shown = (a**orders - b**orders) / (b**orders - c**orders)
        return float(orders[np.argmin(np.abs(np.log(shown / ratio)))])

    def error(self) -> float:
        """The error of the last run, from its difference to the one before."""
        return self.floor + self.differences[-1] / (self._ratio() - 1)

    def _ratio(self) -> float:
        return float((self.steps[-2] / self.steps[-1]) ** min(self.order(), 2.0))  # a higher order may be luck

    def _unsure(self, error: float) -> Flags:
        """Cells whose output may have the other sign: as near to 0 as the runs differ there, or the error is large."""
        last, before = self.ends[-1], self.ends[-2]
        y = self.output(last)
        moved = np.abs(last - before) * 2 / (self._ratio() - 1) + 2 * self.floor
        return (np.abs(y) <= moved) | (np.sign(y) != np.sign(self.output(before))) | ~np.isfinite(moved + 0 * error)

    def _fit(self, step: float) -> float:
        return self.longest * 0.5 ** np.ceil(np.log2(self.longest / step) - 1e-9) if self.divides else step

    def _take(self, step: float) -> None:
        self.steps.append(float(step))
        self.ends.append(self.run(float(step)))
        if len(self.ends) > 1:
            difference = np.abs(self.ends[-1] - self.ends[-2]).max(initial=0.0)
            self.differences.append(float(difference) if np.isfinite(difference) else np.inf)
            self.ends[:-2] = [None] * (len(self.ends) - 2)  # type: ignore[list-item]  # only the last two are looked at
