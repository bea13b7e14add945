"""Phases of a grasp: the time of a finger tiled by what it is doing, out of its events."""

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from tactile.events.event import Event

APPROACH, LOAD, HOLD, TANGENTIAL, SLIP, UNLOAD, RELEASE = (
    "approach", "load", "hold", "tangential load", "slip", "unload", "release",
)  # fmt: skip


class Phase(NamedTuple):
    """What a finger is doing from ``start`` to ``end`` [s]."""

    phase: str
    start: float
    end: float


def phases(events: Iterable[Event], finger: str, start: float, end: float) -> list[Phase]:
    """Return the phases of one finger from ``start`` to ``end`` [s]: they follow each other without gap or overlap.

    Without contact a finger approaches, or releases where a release lasts. In contact it loads until its first hold and
    unloads after its last one; between holds it loads. Tangential load and slip take their time out of all of these.
    """
    mine = [event for event in events if event.finger == finger]
    paint: list[tuple[float, float, str]] = [(start, end, APPROACH)]
    paint += [(event.t, _until(event, end), RELEASE) for event in mine if event.kind == "release"]
    for event in mine:
        if event.kind == "contact":
            over = _until(event, end)
            holds = [hold for hold in mine if hold.kind == "hold" and event.t <= hold.t < over]
            last = max((_until(hold, over) for hold in holds), default=over)
            paint += [(event.t, over, LOAD), (last, over, UNLOAD)]
            paint += [(hold.t, _until(hold, over), HOLD) for hold in holds]
            for kind, phase in (("tangential_load", TANGENTIAL), ("slip", SLIP)):
                inside = [one for one in mine if one.kind == kind and event.t <= one.t < over]
                paint += [(one.t, min(_until(one, over), over), phase) for one in inside]
    return _tiled(paint, start, end)


def _until(event: Event, last: float) -> float:
    return last if event.end is None else event.end


def _tiled(paint: list[tuple[float, float, str]], start: float, end: float) -> list[Phase]:
    """Return what is on top at every time; what comes later in the list covers what comes before."""
    cuts = sorted({start, end, *(min(max(t, start), end) for first, last, _ in paint for t in (first, last))})
    tiles: list[Phase] = []
    for first, last in pairwise(cuts):
        name = next(what for a, b, what in reversed(paint) if a <= first and last <= b)
        if tiles and tiles[-1].phase == name:
            tiles[-1] = tiles[-1]._replace(end=last)
        else:
            tiles.append(Phase(name, first, last))
    return tiles
