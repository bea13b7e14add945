"""Sources of frames: the protocol of live, recorded and simulated sources, and one of given frames."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from cnnsim.support import InputError
from cnnsim.support.notices import Notices
from tactile.core.frame import Frame, TaxelArray


class ForeignFileError(InputError):
    """A file of a known kind that another program wrote: it has no header of a recording."""


class Source(Protocol):
    """An iterable of frames, ordered in time over all fingers.

    ``title``: one line of text; ``arrays``: arrays of the fingers, in the order of ``Frame.finger``; ``modulus``:
    Young's modulus of the cover [Pa], None where it is unknown and the arrays measure force or stress;
    ``frames``: number of frames over all fingers, None if unknown.
    """

    @property
    def title(self) -> str: ...  # noqa: D102 - the class says it
    @property
    def arrays(self) -> tuple[TaxelArray, ...]: ...  # noqa: D102
    @property
    def modulus(self) -> float | None: ...  # noqa: D102
    @property
    def frames(self) -> int | None: ...  # noqa: D102
    def __iter__(self) -> Iterator[Frame]: ...


@dataclass(frozen=True)
class Provenance:
    """Origin of the frames of a source, which conversions keep.

    ``untared``: the readings contain device offsets, so a tare is needed; ``uncalibrated``: names of the fingers whose
    readings are in the unit of the wire, not of their quantity; ``start_ns``: Unix time [ns] at which ``Frame.t`` is 0,
    None if unknown; ``description``: text of the array description of the device; ``choices``: options of the live run
    that recorded it, as JSON; both empty without one; ``damage``: the name of the damaged recording from which the
    frames come and what is damaged, empty if it is complete.
    """

    untared: bool = False
    uncalibrated: tuple[str, ...] = ()
    start_ns: int | None = None
    description: str = ""
    choices: str = ""
    damage: str = ""


def provenance(source: Source) -> Provenance:
    """Return the provenance of a source, the default if it has none."""
    said = getattr(source, "provenance", None)
    return said if isinstance(said, Provenance) else Provenance()


UNCLOSED = "not closed in good order: it ends where its writer was stopped"
"""Damage of a recording whose writer was stopped."""


def damage_text(path: Path, damage: str) -> str:
    """Return a line on the ``damage`` of a recording or of its original, with what helps; empty without damage."""
    if not damage.startswith(f"{path.name}: "):
        return damage and f"{path.name}: made from {damage}"
    helps = f"; `tactile convert {path.name} whole.mcap` makes one that every viewer can index"
    return damage + helps * (damage == f"{path.name}: {UNCLOSED}")


def report_damage(path: Path, damage: str) -> None:
    """Give a notice if a recording, or the recording of which it is a copy, is damaged."""
    if damage:
        Notices.say(f"note: {damage_text(path, damage)}")


@dataclass(frozen=True)
class FrameStream:
    """A source of given frames, iterable as often as ``stream`` is; other attributes as in ``Source``.

    ``tare_requests``: one entry per requested tare that is not taken yet, True to force it; ``notes``: sentences about
    what its reader assumed, repaired or skipped.
    """

    title: str
    arrays: tuple[TaxelArray, ...]
    modulus: float | None
    frames: int | None
    stream: Iterable[Frame] = field(repr=False)
    provenance: Provenance = field(default_factory=Provenance, repr=False)
    tare_requests: deque[bool] = field(default_factory=deque, repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.stream)


def with_frames(source: Source, frames: Iterable[Frame]) -> FrameStream:
    """Return a source of ``frames`` with the other attributes of ``source``, also its tare requests."""
    asked: deque[bool] = getattr(source, "tare_requests", deque())  # of recordings in which a tare was asked for
    known = provenance(source)
    return FrameStream(source.title, source.arrays, source.modulus, source.frames, frames, known, asked)
