"""What a run says in words: the tables on the terminal, and the same as data."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cnnsim.command import console
from tactile.events import Event
from tactile.frame import TaxelArray
from tactile.localise import Load
from tactile.sinks import Collected
from tactile.validity import Validity

TOGETHER = 0.05
"""[s] Code changes of one finger that follow each other faster than this are one line of the table."""


def tables(collected: Collected, arrays: tuple[TaxelArray, ...]) -> None:
    """Print the table of events and a line of figures for each finger."""
    from rich.table import Table  # only for people

    screen = console()
    forces = all(array.quantity == "force" for array in arrays)
    table = Table(title="Events", title_justify="left")
    headings = ["time [s]", "finger", "code", "hand", "meaning", "load: place, Q R F [N]", "latency [µs]"]
    if forces:
        headings.remove("load: place, Q R F [N]")
    for heading in headings:
        table.add_column(heading, justify="right" if heading in ("time [s]", "latency [µs]") else "left")
    digits = -(-sum(2 * array.rows * array.cols for array in arrays) // 4)
    for event, changes in grouped(collected.events):
        what = event.meaning if changes == 1 else f"{event.meaning} ({changes} changes)"
        cells = [f"{event.t:.3f}", event.finger, event.code, f"{event.hand:0{digits}x}", what]
        table.add_row(*cells, *([] if forces else [_located(event.load)]), f"{event.latency * 1e6:.0f}")
    screen.print(table)
    for name, facts in summary(collected, arrays)["fingers"].items():
        texture = f"friction {_figure(facts['friction'])}, roughness {_figure(facts['roughness'])}"
        line = f"{name}: {facts['frames']} frames; {texture}"
        places = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in facts["located"].items())
        screen.print(line + (f"; loads: {places}" if places and not forces else ""), highlight=False)


def grouped(events: Iterable[Event]) -> list[tuple[Event, int]]:
    """Return the events in the order of time, quick successions of code changes as the last one and their number."""
    lines: list[tuple[Event, int]] = []
    open_line: dict[str, int] = {}
    for event in events:
        pattern = event.meaning.startswith(("shear", "contact on"))
        at = open_line.get(event.finger)
        if pattern and at is not None and event.t - lines[at][0].t <= TOGETHER:
            lines[at] = (event, lines[at][1] + 1)
            continue
        open_line.pop(event.finger, None)
        if pattern:
            open_line[event.finger] = len(lines)
        lines.append((event, 1))
    return sorted(lines, key=lambda line: line[0].t)


def summary(collected: Collected, arrays: tuple[TaxelArray, ...]) -> dict[str, Any]:
    """Return the run as plain data: events, and for each finger its frames, loads by validity and texture figures.

    The texture figures are medians over the frames in which they were valid; None if they never were.
    """
    fingers = {}
    for array in arrays:
        rows = collected.table(array.name)
        kinds = {kind.name.lower(): int((rows[:, 9] == kind).sum()) for kind in Validity}
        fingers[array.name] = {
            "frames": len(rows),
            "located": {kind: count for kind, count in kinds.items() if count},
            "friction": _median(rows[:, 10]),
            "roughness": _median(rows[:, 11]),
        }
    events = [
        {
            "t_s": event.t, "finger": event.finger, "code": event.ternary, "arrows": event.code,
            "hand": f"{event.hand:x}", "meaning": event.meaning, "latency_s": event.latency,
        }
        for event in collected.events
    ]  # fmt: skip
    seconds = max((rows[-1][0] - rows[0][0] for rows in collected.rows.values()), default=0.0)
    return {"seconds": seconds, "frames": collected.frames, "fingers": fingers, "events": events}


def _located(load: Load | None) -> str:
    """Say where a load is and how sure that is."""
    if load is None or not np.isfinite(load.F):
        return "" if load is None else load.validity.name.lower().replace("_", " ")
    place = f"({load.x * 1e3:+.2f}, {load.y * 1e3:+.2f}) mm"
    shear = f" {load.Q + 0.0:+.2f} {load.R + 0.0:+.2f}" if np.isfinite(load.Q) else ""
    return f"{place}{shear} {load.F:+.2f}, {load.validity.name.lower()}, {load.taxels} taxels"


def _figure(value: float | None) -> str:
    return "not valid" if value is None else f"{value:.3g}"


def _median(values: np.ndarray) -> float | None:
    valid = values[np.isfinite(values)]
    return float(np.median(valid)) if valid.size else None
