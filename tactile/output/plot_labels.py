"""Event labels above a time axis, in rows without overlap."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tactile.core.frame import HAND
from tactile.events.event import Event

COLOURS = {
    "contact": "tab:green", "grip": "tab:green", "release": "tab:red",
    **dict.fromkeys(("slip", "incipient_slip"), "tab:purple"),
    **dict.fromkeys(("tangential_load", "pull", "lift", "twist", "pinch", "spread"), "tab:brown"),
    **dict.fromkeys(("load", "hold"), "0.6"),
}  # fmt: skip
"""Colours of the shipped kinds of events."""
OWN = "tab:blue"
"""Colour of kinds made by users' detectors."""
MINOR = ("load", "hold", "pull")
"""Kinds that are labelled only in remaining space."""
SIZE = 8
"""[pt] of the labels."""
GAP = 6.0
"""[px] Distance of neighbouring labels of a row."""


@dataclass
class LabelRow:
    """A row of labels, with their extents [px]."""

    y: float
    taken: list[tuple[float, float]]

    def has_room(self, left: float, right: float) -> bool:
        """Return whether an extent is free."""
        return all(right + GAP <= start or left >= end + GAP for start, end in self.taken)


def mark(axes: Iterable[Any], events: Iterable[Event]) -> None:
    """Draw a line for every event on the axes of the signals."""
    for axis in axes:
        for event in events:
            axis.axvline(event.t, color=COLOURS.get(event.kind, OWN), linewidth=0.7, zorder=0)


def label(axis: Any, events: Iterable[Event]) -> int:
    """Draw labels of the events that fit, most important first; return their number.

    The figure must be laid out, because the positions depend on the axis.
    """
    box = axis.get_window_extent()
    inches = axis.get_figure()
    height = SIZE * inches.dpi / 72 * 1.6
    rows = [LabelRow((number + 0.5) * height / box.height, []) for number in range(max(1, int(box.height / height)))]
    drawn = 0
    for event in sorted(events, key=lambda event: event.kind in MINOR):
        text = f"{HAND}: {event.words}" if event.finger == HAND else event.words  # a finger has a pull of its own
        colour = COLOURS.get(event.kind, OWN)
        place = axis.transData.transform((event.t, 0.0))[0]
        written = axis.text(
            event.t, 0, text, transform=axis.get_xaxis_transform(), fontsize=SIZE, color=colour, va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0}, parse_math=False,
        )  # fmt: skip
        width = written.get_window_extent().width
        left = min(max(place, box.x0), box.x1 - width)
        row = next((row for row in rows if row.has_room(left, left + width)), None)
        if row is None or width > box.width:
            written.remove()
            continue
        row.taken.append((left, left + width))
        written.set_position((axis.transData.inverted().transform((left, 0.0))[0], row.y))
        axis.plot(
            [event.t, event.t], [0, row.y], transform=axis.get_xaxis_transform(), color=colour, linewidth=0.7,
            zorder=0, clip_on=False,
        )  # fmt: skip
        drawn += 1
    return drawn
