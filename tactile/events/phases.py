"""Phases of a grasp: divide the time of a finger into approach, load, hold, slip, unload, release."""

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from tactile.events.event import Event

APPROACH, LOAD, HOLD, TANGENTIAL, SLIP, UNLOAD, RELEASE = (
    "approach", "load", "hold", "tangential load", "slip", "unload", "release",
)  # fmt: skip


class Phase(NamedTuple):
    """One phase of a finger from ``start`` to ``end`` [s]."""

    phase: str
    start: float
    end: float


def phases(events: Iterable[Event], finger: str, start: float, end: float) -> list[Phase]:
    """Return the phases of one finger from ``start`` to ``end`` [s], without gap or overlap.

    Without contact the phase is approach, or release where a release lasts. In contact it is load until the first hold,
    unload after the last hold, and load between holds. Tangential load and slip replace all of these.
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
    """Return the topmost interval at every time; later entries of the list cover earlier ones."""
    cuts = sorted({start, end, *(min(max(t, start), end) for first, last, _ in paint for t in (first, last))})
    tiles: list[Phase] = []
    for first, last in pairwise(cuts):
        name = next(what for a, b, what in reversed(paint) if a <= first and last <= b)
        if tiles and tiles[-1].phase == name:
            tiles[-1] = tiles[-1]._replace(end=last)
        else:
            tiles.append(Phase(name, first, last))
    return tiles
