"""Intervals of events: when what a rule watches has been on for long enough, and off for long enough."""

from dataclasses import dataclass
from typing import Literal

from tactile.events.detector_file import EventRule

Turn = Literal["begins", "ends"]


@dataclass
class Tracker:
    """Follows one rule of one finger through time; ``onset`` [s] is where it was first on, ``end`` first off.

    What waits to be told begins again where it is off; of a rule that says what takes it back, where that is on alone.
    """

    rule: EventRule
    active: bool = False
    onset: float | None = None
    end: float | None = None

    @property
    def waits(self) -> bool:
        """Whether time alone may bring a turn."""
        return (self.onset is not None and not self.active) or self.end is not None

    def update(self, t: float, on: bool, back: bool = False) -> Turn | None:
        """Take whether it is on at ``t`` [s], and whether what takes it ``back`` is; return what begins or ends."""
        if not self.active:
            waits = self.onset is not None and self.rule.unless is not None
            if back or not (on or waits):
                self.onset = self.end = None
                return None
            if self.onset is None:
                self.onset = t
            self.end = None if on else t if self.end is None else self.end
            if t - self.onset < self.rule.confirm:
                return None
            self.active = True
            return "begins"
        if on:
            self.end = None
            return None
        if self.end is None:
            self.end = t
        if t - self.end < self.rule.release:
            return None
        self.active = False
        return "ends"
