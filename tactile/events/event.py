"""Events: what has happened to a finger or the hand: an interval, a kind and its data; words are made here alone."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tactile.inverse.load import Load

Data = Mapping[str, str | int | float]
"""An event's data by name; the name of a quantity ends in its SI unit: ``force_n`` [N], ``length_m`` [m]."""
_GAPS = re.compile(r"( ?,)+")  # around data that are not known
UNITS = {"_n": ("N", 2), "_mm": ("mm", 2), "_pa": ("Pa", 0)}
"""Ending of a quantity's name -> its unit in words, and decimal places."""


@dataclass(frozen=True)
class Event:
    """One tactile event of one finger, or of the ``hand``.

    ``t`` [s] its onset, ``end`` [s] where it ends, None while it lasts; ``told`` [s] the time of the frame that decided
    that it began, so that told - t is the delay of detection; ``sequence`` of that frame. ``kind``, ``data`` and
    ``text``: what has happened; ``taxels`` (row, col) concerned, and ``confidence``, their part of the pressed ones;
    the finger's code when it was told as ``arrows`` and as ``ternary`` signs -0+, and ``hand`` the sign code of all
    fingers; ``latency`` [s] from that frame's arrival in the pipeline; ``load`` of the finger in it.
    """

    t: float
    finger: str
    sequence: int
    kind: str
    data: Data
    text: str
    arrows: str
    ternary: str
    hand: int
    latency: float
    load: Load | None
    told: float = float("nan")
    end: float | None = None
    taxels: tuple[tuple[int, int], ...] = ()
    confidence: float = 1.0

    def __repr__(self) -> str:
        return f"Event({self.t:.3f} s, {self.finger}, {self.words!r})"

    @property
    def words(self) -> str:
        """The event in words: its text with the data in it, a length ``x_m`` also as ``x_mm``; what is not known is
        left out."""
        known: dict[str, Any] = {f"{name}m": 1e3 * float(v) for name, v in self.data.items() if name.endswith("_m")}
        said = self.text.format_map(_Said({**self.data, **known}))
        return _GAPS.sub(",", " ".join(said.split())).strip(" :,")

    @property
    def key(self) -> tuple[str, str, float]:
        """What tells an event from the others of its run: it stays the same when the event ends."""
        return self.finger, self.kind, self.t


class _Said(dict[str, Any]):
    """Data as words; a name without data is nothing."""

    def __missing__(self, name: str) -> str:
        return ""

    def __getitem__(self, name: str) -> Any:
        value = super().__getitem__(name) if name in self else self.__missing__(name)
        for ending, (unit, places) in UNITS.items():
            if name.endswith(ending) and isinstance(value, int | float):
                return f"{value:.{places}f} {unit}"
        return value


class EventLog:
    """The events of a run so far, each once: one that ends takes the place of the one that had begun."""

    def __init__(self) -> None:
        self._events: dict[tuple[str, str, float], Event] = {}

    def add(self, begun: Iterable[Event], ended: Iterable[Event]) -> None:
        """Take what has begun and what has ended."""
        for event in (*begun, *ended):
            self._events[event.key] = event

    @property
    def events(self) -> list[Event]:
        """All events in the order of their onsets."""
        return sorted(self._events.values(), key=lambda event: event.t)
