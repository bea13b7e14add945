"""Runs of one transient by shorter and shorter steps, until two of them agree to the accuracy that is wanted.

The classical Runge-Kutta scheme is taken, because of those there are it reaches every accuracy with the least work
(docs/accuracy.md). Its order lies between 4, where nothing saturates, and 2, where the kinks of the characteristic
decide; which it is here, the runs themselves tell, and from it how short the next steps must be.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil

import numpy as np

from cnnsim.accuracy.repeatable import largest
from cnnsim.accuracy.wanted import Wanted
from cnnsim.support import Array, Flags

FIRST_STEP = 0.8
_LOWEST, _HIGHEST = 1.0, 4.5
"""Orders that a run may show."""
_UNKNOWN = 2.5
"""The order that is believed of two runs, which show none."""
_MOST_RUNS, _MOST_FOR_SIGNS = 12, 7
_SMOOTH = 3.2
"""From this order on, where no cell is saturated at one end alone, order 3 is believed; else order 2."""
_SHORTEST, _LONGEST = 1 / 6, 0.7
"""Of the last step that the next one may be: the error of a run is known within the power of that."""
_SAFE, _SAFE_OF_TWO = 0.4, 0.1
"""Of the accuracy that the estimate may be: kinks scatter about the order; two runs may agree by chance."""


@dataclass
class Ladder:
    """Ends of a transient for one step after another.

    ``run`` (step) -> state, from ``start``; ``output`` of a state; ``longest`` step that is stable. Steps divide the
    ``duration``; where ``divides``, they divide ``longest`` by a power of two (of delays and sequences).
    ``highest`` order of the scheme; ``believed``: how many runs cannot agree by chance;
    ``most`` runs; ``held``: cells that keep their state, whose outputs nothing decides.
    """

    run: Callable[[float], Array]
    start: Array
    output: Callable[[Array], Array]
    duration: float
    longest: float
    divides: bool
    floor: float
    highest: float = 4.0
    believed: int = 3
    most: int = _MOST_RUNS
    held: Flags | None = None
    steps: list[float] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)
    differences: list[float] = field(default_factory=list)
    _shown: tuple[int, float] = (0, 2.0)

    def climb(self, wanted: Wanted) -> tuple[float, Flags, bool]:
        """Take runs, after those there are, until one is as wanted.

        Returns the last one's error, which cells it cannot vouch for, and whether it is as wanted.
        """
        first = min(FIRST_STEP, self.longest)
        for part in (1.0, 0.5)[len(self.steps) :]:
            self.take(self._fit(first * part))
        while True:
            error, runs = self.bound(), len(self.steps)
            unsure = self._unsure() if wanted.signs else None
            if unsure is not None:
                done, most = runs >= self.believed and not unsure.any(), min(self.most, _MOST_FOR_SIGNS)
            else:
                done, most = error <= (_SAFE if runs >= self.believed else _SAFE_OF_TWO) * wanted.error, self.most
            if done or runs >= most or (error <= 4 * self.floor and not wanted.signs):
                return self.estimate(), self._unsure() if unsure is None else unsure, done
            self.take(self._fit(self.step_for(self._goal(wanted, error, unsure))))

    def step_for(self, error: float) -> float:
        """Return the step with which a run has about this error, as far as the runs so far tell."""
        order = _UNKNOWN if len(self.steps) < 3 else max(self._sure(), 1.5)
        part = (error / max(self.bound(), 1e-300)) ** (1 / order)
        return self.steps[-1] * float(np.clip(part, _SHORTEST, _LONGEST))

    @property
    def order(self) -> float:
        """The order that the last three runs show; `_LOWEST` where they do not come together as they should."""
        known, order = self._shown
        if known != len(self.steps):
            order = self._order()
            self._shown = len(self.steps), order
        return order

    def _order(self) -> float:
        if len(self.steps) < 3:
            return 2.0
        if not 0 < self.differences[-1] < self.differences[-2]:
            return _LOWEST if self.differences[-1] else _HIGHEST
        (a, b, c), ratio = self.steps[-3:], self.differences[-2] / self.differences[-1]
        orders = np.linspace(_LOWEST, _HIGHEST, 61)
        shown = (a**orders - b**orders) / (b**orders - c**orders)
        return float(orders[np.argmin(np.abs(np.log(shown / ratio)))])

    def bound(self) -> float:
        """What the error of the last run hardly exceeds, from its difference to the one before."""
        return self.floor + self.differences[-1] / (self._ratio(self._sure()) - 1)

    def estimate(self) -> float:
        """The error of the last run: between that bound and what the order shown promises."""
        shown = self.differences[-1] / (self._ratio(4.0 if self._sure() > 2 else min(self.highest, 2.0)) - 1)
        return float(np.sqrt(self.bound() * (shown + self.floor)))

    def _sure(self) -> float:
        order = min(self.order, self.highest)
        if order < _SMOOTH or len(self.steps) < 3:
            return min(order, 2.0)
        return 2.0 if ((np.abs(self.start) >= 1) != (np.abs(self.ends[-1]) >= 1)).any() else 3.0

    def _ratio(self, order: float) -> float:
        return float((self.steps[-2] / self.steps[-1]) ** order)

    def _goal(self, wanted: Wanted, error: float, unsure: Flags | None) -> float:
        if unsure is None:
            return 0.75 * _SAFE * wanted.error
        nearest = np.abs(self.output(self.ends[-1]))[unsure].min(initial=error)
        return float(np.clip(nearest / 4, error / 64, error / 8))

    def _unsure(self) -> Flags:
        """Cells whose output may have the other sign: as near to 0 as the runs differ there, or not finite."""
        last, before = self.ends[-1], self.ends[-2]
        y = self.output(last)
        moved = np.abs(last - before) * 2 / (self._ratio(min(self.order, self.highest, 2.0)) - 1) + 2 * self.floor
        unsure: Flags = (np.abs(y) <= moved) | (np.sign(y) != np.sign(self.output(before))) | ~np.isfinite(moved)
        return unsure if self.held is None else unsure & ~self.held

    def _fit(self, step: float) -> float:
        if self.divides:
            return float(self.longest * 0.5 ** np.ceil(np.log2(self.longest / step) - 1e-9))
        number = ceil(self.duration / step - 1e-9)
        if self.steps and self.duration / number >= self.steps[-1]:
            number = round(self.duration / self.steps[-1]) + 1
        return self.duration / number

    def take_near(self, step: float) -> None:
        """Run by about a step, but by one that is stable."""
        self.take(self._fit(min(step, self.longest)))

    def take(self, step: float) -> None:
        """Run by a step, and see how far its end is from that of the run before."""
        self.steps.append(float(step))
        self.ends.append(self.run(float(step)))
        if len(self.ends) > 1:
            self.differences.append(largest(self.ends[-1] - self.ends[-2]))
            self.ends[:-2] = [None] * (len(self.ends) - 2)  # type: ignore[list-item]  # only the last two are looked at
