"""Slices of long computations, between which Python handles signals and reports progress.

Compiled loops and kernels do not handle signals. They get work in slices of about `SLICE` seconds, whose length follows
the speed of the slice before; results and checks stay the same.
"""

import math
from collections.abc import Sequence
from time import perf_counter

from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support.progress import watcher

SLICE = 0.1
"""Seconds of a slice: the longest delay of Ctrl-C. The overhead of a slice is some microseconds."""
FIRST = 1 << 24
"""Weighted neighbours summed in the first slice, before the speed is known: 3 to 50 ms."""
PIECE = 1 << 28
"""Such sums in one call that cannot end between two steps; larger calls are cut into rows or tiles."""
EXPONENTIALS = 64
"""Such sums that take as long as the closed form of a cell."""
TERM = 8
"""Such sums that take as long as one value of a term."""
_FASTER, _SLOWER = 8.0, 0.1
"""Bounds of the ratio of a slice to the one before, because other processes can slow a slice down."""


class Pace:
    """The units of work that are ``left`` in this slice of a plan; ``work`` estimates the sums in one unit.

    The first slice has at most ``most`` units. A slice has a multiple of ``together`` units, which cost less together
    than one by one. The caller handles signals between slices.
    """

    __slots__ = ("_most", "_plan", "_since", "_together", "left")

    def __init__(self, plan: Plan, work: float, together: int = 1, most: float = FIRST) -> None:
        self._plan, self._together, self._most = plan, together, max(1.0, min(most, FIRST / max(1.0, work)))
        self._since = perf_counter()
        self.left = self._whole()

    def _whole(self) -> int:
        return self._together * max(1, int(self._most) // self._together)

    def turn(self, steps: int, rate: float) -> None:
        """Begin the next slice after ``steps`` steps in total, and report progress.

        ``rate`` is the largest |dx/dt| of the last check, NaN without one.
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
        """Report to the progress watcher that the transient has ended."""
        watched_by = watcher()
        if watched_by is not None:
            watched_by.over()


def pieces(count: int, work: float, workers: int = 1) -> Sequence[tuple[int, int]]:
    """Return (first, after) of the pieces into which ``count`` rows or tiles with ``work`` sums each are cut.

    All pieces but the last are multiples of ``workers``.
    """
    if count * work <= PIECE:
        return ((0, count),)
    most = workers * max(1, int(PIECE / work) // workers)
    return [(first, min(count, first + most)) for first in range(0, count, most)]
