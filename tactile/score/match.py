"""Matching of detected and known events: precision, recall and errors of the onset."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

WINDOW = 0.05
"""[s] Largest error of the onset of a right event."""


@dataclass
class Tally:
    """Counts of one kind of event: ``hit``, ``false``, ``missed``; ``errors`` [s] of the hits, detected minus known."""

    hit: int = 0
    false: int = 0
    missed: int = 0
    errors: list[float] = field(default_factory=list)

    def add(self, found: Iterable[float], known: Iterable[float], window: float = WINDOW) -> None:
        """Match the times of one finger of one recording: each known time with the nearest detected one, once."""
        left = sorted(found)
        for time in sorted(known):
            near = min(left, key=lambda one: abs(one - time), default=None)
            if near is None or abs(near - time) > window:
                self.missed += 1
                continue
            left.remove(near)
            self.hit += 1
            self.errors.append(near - time)
        self.false += len(left)

    @property
    def precision(self) -> float:
        """Share of the detected events that are right; NaN without any."""
        return self.hit / (self.hit + self.false) if self.hit + self.false else float("nan")

    @property
    def recall(self) -> float:
        """Share of the known events that are detected; NaN without any."""
        return self.hit / (self.hit + self.missed) if self.hit + self.missed else float("nan")

    def plain(self) -> dict[str, Any]:
        """Return all as plain data, the errors as their 5, 50 and 95 % points [s]."""
        points = [float(point) for point in np.percentile(self.errors, (5, 50, 95))] if self.errors else None
        ratios = {name: None if np.isnan(value) else round(value, 4) for name, value in self.ratios()}
        return {"hit": self.hit, "false": self.false, "missed": self.missed, **ratios, "onset_error_s": points}

    def ratios(self) -> Sequence[tuple[str, float]]:
        """Return precision and recall by name."""
        return ("precision", self.precision), ("recall", self.recall)
