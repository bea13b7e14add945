"""Bars of events over time, from onset to end, one row a kind."""

from collections.abc import Sequence
from typing import Any

from tactile.core.frame import HAND
from tactile.events.event import Event

COLOURS = {
    "contact": "#009e73", "grip": "#009e73", "release": "#d55e00",
    **dict.fromkeys(("slip", "incipient_slip"), "#cc79a7"),
    **dict.fromkeys(("tangential_load", "pull", "lift", "twist", "pinch", "spread"), "#e69f00"),
    **dict.fromkeys(("load", "hold"), "0.6"),
}  # fmt: skip
"""Colours of the shipped kinds of events, which colour-blind readers can distinguish."""
OWN = "#0072b2"
"""Colour of kinds made by users' detectors."""
MINOR = ("load", "hold", "pull")
"""Kinds that a view labels only in remaining space."""
ROWS = 12
"""Largest number of rows; further kinds are counted in the title."""
ROW = 0.26
"""[inch] Height of a row."""
SIZE = 8
"""[pt] of the texts."""
GAP = 6.0
"""[px] Distance of neighbouring texts of a row."""
BAR, TEXT = (0.2, 0.24), -0.2
"""Offset of the bar's middle and its height, and offset of the text, in rows."""
RIGHT = 3.0
"""[px] Distance of a text from the onset."""

Row = tuple[str, str]
"""Finger or hand, and kind."""


def rows_of(events: Sequence[Event], run: Sequence[Event]) -> list[Row]:
    """Return the rows of a finger's events: kinds in the order of their first onset in a run, the hand's last."""
    kinds = list(dict.fromkeys(event.kind for event in run))
    found = dict.fromkeys((event.finger, event.kind) for event in events)
    return sorted(found, key=lambda row: (row[0] == HAND, kinds.index(row[1])))[:ROWS]


def draw_events(axis: Any, events: Sequence[Event], rows: Sequence[Row], end: float) -> None:
    """Draw a bar for each event of ``rows``; one without an end reaches to ``end`` [s].

    The row's label names the kind, with "hand" for events of all fingers.
    """
    names = [f"hand: {kind.replace('_', ' ')}" if of == HAND else kind.replace("_", " ") for of, kind in rows]
    axis.set_yticks([place + BAR[0] / 2 for place in range(len(rows))], names, fontsize=SIZE)
    axis.set_ylim(max(len(rows), 1) - 0.5, -0.5)
    axis.tick_params(left=False, labelbottom=False, bottom=False)
    axis.spines[["left", "right", "top", "bottom"]].set_visible(False)
    places = {row: place for place, row in enumerate(rows)}
    for event in events:
        if (event.finger, event.kind) in places:
            place, colour = places[event.finger, event.kind] + BAR[0], COLOURS.get(event.kind, OWN)
            until = end if event.end is None else event.end
            axis.barh(place, max(until - event.t, 0.0), left=event.t, height=BAR[1], color=colour, linewidth=0)
            mark = [place - BAR[1] / 2, place + BAR[1] / 2]  # visible also where the bar is too short
            axis.plot([event.t, event.t], mark, color=colour, linewidth=2, solid_capstyle="butt", clip_on=False)


def label_events(axis: Any, events: Sequence[Event], rows: Sequence[Row]) -> None:
    """Write the data of each event above its bar where no other text of the row is in the way.

    The figure must be laid out, because the positions depend on the axis.
    """
    right = dict.fromkeys(rows, float("-inf"))
    box = axis.get_window_extent()
    for event in events:
        row, text = (event.finger, event.kind), short_words(event)
        if row not in right or not text:
            continue
        place = rows.index(row) + TEXT
        written = axis.text(event.t, place, text, fontsize=SIZE, color="0.25", va="center", parse_math=False)
        width = written.get_window_extent().width
        start = min(axis.transData.transform((event.t, place))[0] + RIGHT, box.x1 - width)
        if start < max(right[row] + GAP, box.x0):
            written.remove()
            continue
        written.set_x(axis.transData.inverted().transform((start, 0.0))[0])
        right[row] = start + width


def short_words(event: Event) -> str:
    """Return the text of an event without its kind, which the row names."""
    return event.words.removeprefix(event.kind.replace("_", " ")).strip(" :,")
