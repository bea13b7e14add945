"""Event tracker: confirms the begin and the end of an event rule over time."""

from dataclasses import dataclass
from typing import Literal

from tactile.events.detector_file import EventRule

Change = Literal["begins", "ends"]


@dataclass
class Tracker:
    """State of one rule on one finger; ``onset`` [s] is when it first came on, ``end`` when it first went off.

    An unconfirmed onset is dropped when the signal goes off; with ``unless`` in the rule, only when that comes on.
    """

    rule: EventRule
    active: bool = False
    onset: float | None = None
    end: float | None = None

    @property
    def pending(self) -> bool:
        """Whether a transition is pending."""
        return (self.onset is not None and not self.active) or self.end is not None

    def update(self, t: float, on: bool, back: bool = False) -> Change | None:
        """Process the signal ``on`` and its veto ``back`` at ``t`` [s]; return the transition, if any."""
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
