"""Events: what has happened to one finger, as a kind and its data; their words are made here and nowhere else."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from tactile.inverse.load import Load

Data = Mapping[str, str | int | float]
"""An event's data by name; the name of a quantity ends in its SI unit: ``force_n`` [N], ``length_m`` [m]."""


class EventKind(Enum):
    """A kind of event. Each detector lists its own kinds: a name, and the words, with the data's names in braces."""

    @property
    def label(self) -> str:
        """The kind as it is written in JSON."""
        return self.name.lower()


Happening = tuple[EventKind, Data]
"""What a detector gives: the kind of an event and its data."""


@dataclass(frozen=True)
class Event:
    """One tactile event of one finger.

    ``t`` [s] and ``sequence`` of the frame it rests on; ``kind`` and ``data``: what has happened; the finger's code as
    ``arrows`` and as ``ternary`` signs -0+; ``hand`` the sign code of all fingers; ``latency`` [s] from the frame's
    arrival in the pipeline to this event; ``load`` the one located in that frame.
    """

    t: float
    finger: str
    sequence: int
    kind: EventKind
    data: Data
    arrows: str
    ternary: str
    hand: int
    latency: float
    load: Load | None

    def __repr__(self) -> str:
        return f"Event({self.t:.3f} s, {self.finger}, {self.words!r})"

    @property
    def words(self) -> str:
        """The event in words: its kind's text with the data in it, where a length ``x_m`` is also ``x_mm``."""
        lengths = {f"{name}m": 1e3 * float(value) for name, value in self.data.items() if name.endswith("_m")}
        return str(self.kind.value).format(**self.data, **lengths)
