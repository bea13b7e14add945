"""Events of the hand: grip, lift, pull and twist, from events of fingers that touch together."""

from collections.abc import Iterable
from dataclasses import replace

from tactile.core.frame import HAND
from tactile.events.event import Event

TOGETHER = 0.25
"""[s] Largest time between the onsets of two tangential loads that make one event of the hand."""
OPPOSITE = {"+x": "-x", "-x": "+x", "+y": "-y", "-y": "+y"}


class Hand:
    """Combines events of fingers to events of the hand. A hand of one finger has none.

    ``grip``: two or more fingers in contact. During a grip, tangential loads of two fingers in the same direction are a
    ``lift`` where the skin is pulled down (+y, the weight of the object) and a ``pull`` otherwise; in opposite
    directions they are a ``twist``. Each lasts until the first of the two ends.
    """

    def __init__(self, fingers: int) -> None:
        self._fingers = fingers
        self._touching: dict[str, Event] = {}
        self._drawn: dict[str, Event] = {}
        self._grip: Event | None = None
        self._shared: Event | None = None

    def join(self, begun: Iterable[Event], ended: Iterable[Event]) -> tuple[list[Event], list[Event]]:
        """Process events of fingers and return the events of the hand that begin and end with them."""
        joined: list[Event] = []
        parted: list[Event] = []
        if self._fingers < 2:
            return joined, parted
        for event in ended:
            if event.kind == "contact":
                self._touching.pop(event.finger, None)
                if self._grip is not None and len(self._touching) < 2:
                    parted.append(replace(self._grip, end=event.end))
                    self._grip = None
            elif event.kind == "tangential_load":
                self._drawn.pop(event.finger, None)
                if self._shared is not None and len(self._drawn) < 2:
                    parted.append(replace(self._shared, end=event.end))
                    self._shared = None
        for event in begun:
            if event.kind == "contact":
                self._touching[event.finger] = event
                if self._grip is None and len(self._touching) >= 2:
                    self._grip = _of_hand(event, "grip", "grip of {fingers} fingers", fingers=len(self._touching))
                    joined.append(self._grip)
            elif event.kind == "tangential_load" and self._grip is not None:
                self._drawn[event.finger] = event
                shared = self._share(event)
                if shared is not None:
                    self._shared = shared
                    joined.append(shared)
        return joined, parted

    def _share(self, event: Event) -> Event | None:
        """Return the event that the newest tangential load makes with that of another finger."""
        others = [one for one in self._drawn.values() if one.finger != event.finger and event.t - one.t <= TOGETHER]
        mine = str(event.data.get("direction", ""))
        if self._shared is not None or not mine:
            return None
        for other in others:
            theirs = str(other.data.get("direction", ""))
            if theirs == mine:
                kind = "lift" if mine == "+y" else "pull"
                return _of_hand(event, kind, f"{kind} {{direction}}", direction=mine)
            if OPPOSITE.get(mine) == theirs:
                return _of_hand(event, "twist", "twist of the fingers against each other")
        return None


def _of_hand(event: Event, kind: str, text: str, **data: str | int) -> Event:
    return replace(event, finger=HAND, kind=kind, data=data, text=text, taxels=(), load=None, confidence=1.0)
