"""Bounds of what effects change in the readings of one finger, one by one and left out together."""

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL
from tactile.simulator.field import Field
from tactile.simulator.seen import RARE, Seen

FIELD = "accuracy of the field"
"""What stands for the field's own accuracy among the effects: to compute it roughly is to leave that out."""
SAFE = 1.25
"""What is found on the frames that tell most may be so many times larger on another one."""
ZERO: Floats = np.zeros(1)
"""What nothing changes."""


@dataclass
class FingerBounds:
    """What the effects change in the readings of one finger, at most.

    ``terms``: name -> what a fixed effect on fields changes in the frames tried; ``reach``: name -> what any other
    effect changes behind all that follow it, those in ``normal`` adding up by their squares; ``growth``: by what
    changes of the field may grow behind it; ``grains``: name -> what the smallest change before it may become, and the
    chance of that per unit of change; ``untried``: of which a trial could tell more, but costs more than it may save.
    """

    terms: dict[str, Floats] = field(default_factory=dict)
    reach: dict[str, float] = field(default_factory=dict)
    normal: set[str] = field(default_factory=set)
    untried: set[str] = field(default_factory=set)
    growth: float = 1.0
    grains: dict[str, tuple[float, float]] = field(default_factory=dict)
    whole: Floats = field(default_factory=lambda: ZERO)

    def sizes(self) -> dict[str, float]:
        """What each effect changes."""
        sizes = self.reach.copy()
        for name, change in self.terms.items():
            sizes[name] = largest(change) * SAFE * self.growth
        return sizes


class LeftOut:
    """Effects that are left out on one finger, and what they change together."""

    def __init__(self, found: FingerBounds) -> None:
        self._found, self._terms = found, ZERO
        self._plain = self._squares = self._growth = 0.0

    def change(self, off: Collection[str], more: str = "") -> tuple[float, float]:
        """What they change at most, one ``more`` among them, and what steps of all but those ``off`` make of it."""
        plain, squares, found = self._plain, self._squares, self._found
        if more in found.terms:
            change = plain + math.sqrt(squares) + SAFE * largest(self._terms + found.terms[more]) * found.growth
        else:
            if more in found.normal:
                squares += found.reach[more] ** 2
            elif more:
                plain += found.reach[more]
            change = plain + math.sqrt(squares)
            if self._growth:
                change += SAFE * largest(self._terms) * self._growth
        stepped = change
        for one, (grain, chance) in found.grains.items():
            if change * chance > RARE and one != more and one not in off:
                stepped += grain
        return change, stepped

    def add(self, name: str) -> None:
        """Leave out one more."""
        found = self._found
        if name in found.terms:
            self._terms, self._growth = self._terms + found.terms[name], found.growth
        elif name in found.normal:
            self._squares += found.reach[name] ** 2
        else:
            self._plain += found.reach[name]


def largest(values: Any) -> float:
    """The largest of absolute values, 0 of none."""
    return float(np.abs(values).max(initial=0))


def behind(seen: Seen, now: Field) -> Seen:
    """The bounds of the ideal field, behind effects on it, from the frames that tell most."""
    scale = SAFE * largest(now.values) / seen.largest if seen.largest > 0 else 1.0
    low, high = (end * scale for end in seen.normal)
    normal = now.values[..., NORMAL]  # what sticks also pulls
    low, high = min(low, SAFE * float(normal.min(initial=0))), max(high, SAFE * float(normal.max(initial=0)))
    return seen._replace(largest=seen.largest * scale, normal=(low, high), change=seen.change * scale)
