"""What is known of a finger's readings over a whole recording: from it effects bound what they can change."""

import math
from functools import cache
from statistics import NormalDist
from typing import NamedTuple

from tactile.core.frame import TaxelArray

RARE = 1e-6
"""A bound of something random holds for all seeds but so many."""


class Seen(NamedTuple):
    """Bounds on the readings of one finger at one place in the chain of effects.

    ``largest`` |reading|; ``normal``: the least and the largest normal reading; ``change`` of a reading from one frame
    to the next; all in the unit of the readings. ``unit`` and ``full_scale`` as in ``Batch``; ``rate`` [Hz];
    ``frames``: how many.
    """

    array: TaxelArray
    unit: float
    full_scale: float
    rate: float
    frames: int
    largest: float
    normal: tuple[float, float]
    change: float

    @property
    def taxels(self) -> int:
        """How many there are."""
        return self.array.rows * self.array.cols

    @property
    def duration(self) -> float:
        """From the first frame to the last [s]."""
        return (self.frames - 1) / self.rate

    def after(self, reach: float, random: bool) -> "Seen":
        """The bounds behind an effect that changes no reading by more than ``reach``.

        What is random changes from frame to frame by all of it, what is not in proportion to the signal.
        """
        low, high = self.normal
        share = reach / self.largest if self.largest > 0 else 0.0
        change = self.change + 2 * reach if random else self.change * (1 + 2 * share)
        return Seen(
            self.array, self.unit, self.full_scale, self.rate, self.frames, self.largest + reach,
            (low - reach, high + reach), change,
        )  # fmt: skip


@cache
def sigmas(count: float) -> float:
    """The largest of so many standard normal numbers, exceeded for one in 1 / RARE seeds."""
    return NormalDist().inv_cdf(1 - RARE / (2 * max(count, 1)))


@cache
def longest(count: float) -> float:
    """The largest length of so many standard normal vectors in space, exceeded for one in 1 / RARE seeds.

    Solves P(|v| > r) = erfc(r / sqrt(2)) + sqrt(2 / pi) r exp(-r^2 / 2) = RARE / count by halving.
    """
    low, high, wanted = 0.0, 40.0, RARE / max(count, 1)
    for _ in range(50):
        r = (low + high) / 2
        beyond = math.erfc(r / math.sqrt(2)) + math.sqrt(2 / math.pi) * r * math.exp(-r * r / 2) > wanted
        low, high = (r, high) if beyond else (low, r)
    return high


@cache
def longest_run(chance: float, count: float) -> int:
    """The longest row of events of that chance in so many trials, exceeded for one in 1 / RARE seeds."""
    run, left = 0, count
    while run < count and left * chance > RARE:
        run, left = run + 1, left * chance
    return run
