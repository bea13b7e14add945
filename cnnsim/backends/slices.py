"""Slices of long computations: how much is done before Python is asked whether somebody wants to stop.

Compiled loops and kernels do not hear a signal. So they are given work by slices of about `SLICE` seconds, whose length
follows the rate of the slice before; what is computed, and when it is checked, stays the same.
"""

import math
from collections.abc import Sequence
from time import perf_counter

from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support.progress import watcher

SLICE = 0.1
"""Seconds. A stop is heard after one slice; and the bookkeeping of a slice, some microseconds, is nothing to that."""
FIRST = 1 << 24
"""Sums of a weighted neighbour in the first slice, before the rate is known: 3 to 50 ms."""
PIECE = 1 << 28
"""Such sums in one call that cannot end between two steps: what needs more is cut into rows or tiles."""
EXPONENTIALS = 64
"""Such sums that take as long as the exponentials in the closed form of a cell."""
TERM = 8
"""Such sums that take as long as one value of a term."""
_FASTER, _SLOWER = 8.0, 0.1
"""How much longer or shorter than the last slice the next one may be: a slice can be slow because of others."""


class Pace:
    """How many units of work are left in this slice of a plan; ``work`` is a guess at the sums in one unit.

    The first slice has ``most`` units at most.

    A slice has whole multiples of ``together`` units, where that many are done at less cost than one by one: who does
    them hears a signal while it does them, however long they take.
    """

    __slots__ = ("_most", "_plan", "_since", "_together", "left")

    def __init__(self, plan: Plan, work: float, together: int = 1, most: float = FIRST) -> None:
        self._plan, self._together, self._most = plan, together, max(1.0, min(most, FIRST / max(1.0, work)))
        self._since = perf_counter()
        self.left = self._whole()

    def _whole(self) -> int:
        return self._together * max(1, int(self._most) // self._together)

    def turn(self, steps: int, rate: float) -> None:
        """Begin the next slice: the last one took as long as it took, and so many ``steps`` are done in all.

        ``rate`` is the largest |dx/dt| that the last check found, NaN where none looked for it.
        """
        now = perf_counter()
        factor = SLICE / max(now - self._since, 1e-6)
        self._most = max(1.0, self._whole() * min(_FASTER, max(_SLOWER, factor)))
        self._since, self.left = now, self._whole()
        watched_by = watcher()
        if watched_by is None:
            return
        t, duration = steps * self._plan.step, self._plan.duration
        if duration == "settled":
            rest = "" if math.isnan(rate) else f", |dx/dt| {rate:.2g} to become {SETTLED_RATE:g}"
            watched_by(None, f"t = {t:.4g}{rest}")
        else:
            watched_by(min(1.0, t / duration), f"t = {t:.4g} of {duration:g}")

    @staticmethod
    def over() -> None:
        """The transient has ended."""
        watched_by = watcher()
        if watched_by is not None:
            watched_by.over()


def pieces(count: int, work: float, workers: int = 1) -> Sequence[tuple[int, int]]:
    """Return (first, after) of the pieces into which ``count`` rows or tiles are cut, with ``work`` sums in each.

    All but the last are dealt out to so many ``workers`` without a remainder.
    """
    if count * work <= PIECE:
        return ((0, count),)
    most = workers * max(1, int(PIECE / work) // workers)
    return [(first, min(count, first + most)) for first in range(0, count, most)]
