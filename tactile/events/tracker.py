"""Intervals of events: when what a rule watches has been on for long enough, and off for long enough."""

from dataclasses import dataclass
from typing import Literal

from tactile.events.detector_file import EventRule

Turn = Literal["begins", "ends"]


@dataclass
class Tracker:
    """Follows one rule of one finger through time; ``onset`` [s] is where it was first on, ``end`` first off."""

    rule: EventRule
    active: bool = False
    onset: float | None = None
    end: float | None = None

    @property
    def waits(self) -> bool:
        """Whether time alone may bring a turn."""
        return (self.onset is not None and not self.active) or self.end is not None

    def update(self, t: float, on: bool) -> Turn | None:
        """Take whether it is on at ``t`` [s], and return whether the event begins or ends with this frame."""
        if not self.active:
            if not on:
                self.onset = None
                return None
            if self.onset is None:
                self.onset = t
            if t - self.onset < self.rule.confirm:
                return None
            self.active, self.end = True, None
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
