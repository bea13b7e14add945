"""Depth of a superstep: the steps that cost least a step, from the measured rates of stepping and of the disk."""

import math
from collections.abc import Sequence

from cnnsim.supersteps.block_task import BlockReport

FIRST, PART, SLEEPING = 256, 16, 32
"""Steps of the first superstep, before anything is known: at most `FIRST`, and a halo of one part in so many; where
blocks may sleep of one in `SLEEPING`, as a halo that is deep keeps blocks awake that a wave will not reach."""
MOST = 256
"""The most steps of a superstep: what a crash may cost."""


def first_depth(side: int, reach: int, *, sleeps: bool) -> int:
    """Return the steps of the first superstep."""
    return max(1, min(FIRST, side // ((SLEEPING if sleeps else PART) * max(1, reach))))


class Depth:
    """How many steps the next superstep has; ``fixed`` where it was said."""

    def __init__(self, side: int, reach: int, every: int | None, fixed: int | None, *, sleeps: bool = False) -> None:
        self._side, self._reach, self._every, self._fixed = side, reach, every, fixed
        self._steps = self._whole(first_depth(side, reach, sleeps=sleeps))

    def steps(self, left: int) -> int:
        """Return how many steps to take of those that are ``left``; the same in all supersteps, as far as they go."""
        if self._fixed or self._every is not None or not left:
            return min(self._fixed or self._steps, left)
        return math.ceil(left / math.ceil(left / self._steps))

    def learn(self, reports: Sequence[BlockReport], steps: int) -> None:
        """Take how long the tasks of a superstep of so many steps took; the middle task counts."""
        if self._fixed or not reports:
            return
        disk, stepping = (
            sorted(values)[len(reports) // 2] for values in zip(*((r.disk, r.stepping) for r in reports), strict=True)
        )
        cell = stepping / (steps * self._width(steps) ** 2)
        choices = {self._whole(2 ** (half / 2)) for half in range(2 * MOST.bit_length() - 1)}
        self._steps = min(choices, key=lambda d: (cell * d * self._width(d) ** 2 + disk) / d)

    def _width(self, steps: int) -> int:
        """Return the side of what is computed, the mean over the steps: a halo is needed less from step to step."""
        return self._side + steps * self._reach

    def _whole(self, steps: float) -> int:
        """Return about so many steps: whole times between checks, and a halo of half a block at most."""
        most = max(1, min(int(steps), self._side // (2 * max(1, self._reach))))
        return most if self._every is None or most < self._every else most // self._every * self._every
