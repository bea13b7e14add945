"""Events that a page shows: they end, and their contacts grow."""

from dataclasses import replace

from tactile.events.event import Event
from tactile.pipeline import FrameReport

Log = dict[tuple[str, str, float], Event]
"""Events by their keys; a contact is on as many taxels as it pressed at most so far."""


def noted(log: Log, report: FrameReport) -> None:
    """Keep the events of a report, and the taxels of a contact that grows."""
    for event in (*report.events, *report.ended):
        log[event.key] = _on(event, _taxels(log.get(event.key)))
    pressed = report.code.pressed
    for key, event in reversed(log.items()) if pressed else ():
        if key[:2] == (report.array.name, "contact"):
            if event.end is None and pressed > _taxels(event):
                log[key] = _on(event, pressed)
            return


def _taxels(event: Event | None) -> float:
    return float(event.data.get("taxels", 0)) if event is not None and event.kind == "contact" else 0.0


def _on(event: Event, taxels: float) -> Event:
    """Return a contact whose number of taxels is at least this."""
    return replace(event, data={**event.data, "taxels": int(taxels)}) if taxels > _taxels(event) else event
