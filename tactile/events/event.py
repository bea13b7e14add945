"""Events: intervals in time with a kind, data and a text, of a finger or of the hand."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tactile.inverse.load import Load

Data = Mapping[str, str | int | float]
"""An event's data by name; the name of a quantity ends in its SI unit: ``force_n`` [N], ``length_m`` [m]."""
_GAPS = re.compile(r"( ?,)+")  # around unknown data
UNITS = {"_n": ("N", 2), "_mm": ("mm", 2), "_pa": ("Pa", 0)}
"""Suffix of a quantity -> its unit and decimal places in the text."""
MOST_NEWTONS = 500.0
"""[N] Force of a finger above which readings are taken for another unit, such as millinewtons."""


@dataclass(frozen=True)
class Event:
    """One tactile event of one finger, or of the ``hand``.

    ``t`` [s] is the onset, ``end`` [s] the end, None while the event lasts. ``told`` [s] is the time of the frame with
    which the event was reported, so told - t is the delay of detection; ``sequence`` is the number of that frame.
    ``kind``, ``data`` and ``text`` describe the event; ``taxels`` (row, col) take part, and ``confidence`` is their
    share of the pressed taxels. ``arrows`` and ``ternary`` are the code of the finger in that frame, ``hand`` the sign
    code of all fingers. ``latency`` [s] counts from the arrival of that frame in the pipeline; ``load`` is the load of
    the finger in that frame.
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
        """The text with the data filled in; a length ``x_m`` is also there as ``x_mm``; unknown data are left out."""
        known: dict[str, Any] = {f"{name}m": 1e3 * float(v) for name, v in self.data.items() if name.endswith("_m")}
        said = self.text.format_map(_TextData({**self.data, **known}))
        return _GAPS.sub(",", " ".join(said.split())).strip(" :,")

    @property
    def key(self) -> tuple[str, str, float]:
        """Identity of an event within its run: it stays the same when the event ends."""
        return self.finger, self.kind, self.t


class _TextData(dict[str, Any]):
    """Event data by name, formatted with their units; an unknown name gives an empty text."""

    def __missing__(self, name: str) -> str:
        return ""

    def __getitem__(self, name: str) -> Any:
        value = super().__getitem__(name) if name in self else self.__missing__(name)
        for ending, (unit, places) in UNITS.items():
            if name.endswith(ending) and isinstance(value, int | float):
                if unit == "N" and abs(value) > MOST_NEWTONS:
                    return f"{value:.0f} in the unit of the readings"
                return f"{value:.{places}f} {unit}"
        return value


class EventLog:
    """The events of a run so far; an ended event replaces the one that began."""

    def __init__(self) -> None:
        self._events: dict[tuple[str, str, float], Event] = {}

    def add(self, begun: Iterable[Event], ended: Iterable[Event]) -> None:
        """Add events that begin and events that end."""
        for event in (*begun, *ended):
            self._events[event.key] = event

    @property
    def events(self) -> list[Event]:
        """All events, sorted by onset."""
        return sorted(self._events.values(), key=lambda event: event.t)
