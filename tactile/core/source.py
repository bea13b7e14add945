"""Sources of frames: what live, recorded and simulated ones have in common, and one of given frames."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

from tactile.core.frame import Frame, TaxelArray


class Source(Protocol):
    """An iterable of frames, ordered in time over all fingers.

    ``title``: a line for people; ``arrays``: the fingers' arrays, in the order of ``Frame.finger``; ``modulus``:
    Young's modulus of the cover [Pa], None where the arrays measure force or stress and it is not known;
    ``frames``: how many frames there are over all fingers, None where nobody knows.
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
    """Where a source's frames come from, which conversions keep.

    ``untared``: the readings have the offsets of a device, so that a tare is wanted; ``uncalibrated``: names of the
    fingers whose readings are in the unit of the wire and not in that of their array's quantity; ``start_ns``: the
    time since 1970 [ns] from which ``Frame.t`` counts, None where nobody knows; ``description``: the text of the
    device's array description, ``choices`` the options of the live run that recorded it, as JSON, empty without one.
    """

    untared: bool = False
    uncalibrated: tuple[str, ...] = ()
    start_ns: int | None = None
    description: str = ""
    choices: str = ""


def provenance(source: Source) -> Provenance:
    """Return where a source's frames come from; sources of one's own need not say it."""
    said = getattr(source, "provenance", None)
    return said if isinstance(said, Provenance) else Provenance()


@dataclass(frozen=True)
class FrameStream:
    """A source of given frames, as often as ``stream`` can be gone through; the others as in ``Source``.

    ``tare_requests``: whether by force, one for each tare that was asked for and not yet taken.
    """

    title: str
    arrays: tuple[TaxelArray, ...]
    modulus: float | None
    frames: int | None
    stream: Iterable[Frame] = field(repr=False)
    provenance: Provenance = field(default_factory=Provenance, repr=False)
    tare_requests: deque[bool] = field(default_factory=deque, repr=False)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.stream)
