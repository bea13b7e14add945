"""What a run says in words: the tables on the terminal, and the same as data."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cnnsim.support.command_line import console
from tactile.core.frame import TaxelArray
from tactile.events.events import Event
from tactile.inverse.localise import Load
from tactile.inverse.validity import Validity
from tactile.output.record import Collected

TIME, CODE, HAND, LOAD, LATENCY = "time [s]", "code", "hand", "load: (x, y) [mm], Q R F [N]", "latency [µs]"
LEGIBLE = 16
"""Most taxels of an array whose code is in the table, and most hexadecimal digits of the hand's code."""
TOGETHER = 0.05
"""[s] Code changes of one finger that follow each other faster than this are one line of the table."""


def tables(collected: Collected, arrays: tuple[TaxelArray, ...]) -> None:
    """Print the table of events and a line of figures for each finger; codes of many taxels are left to the record."""
    from rich.markup import escape  # only for people
    from rich.table import Table  # the same

    screen = console()
    forces = all(array.quantity == "force" for array in arrays)
    table = Table(title="Events", title_justify="left")
    taxels = [array.rows * array.cols for array in arrays]
    digits = -(-sum(2 * count for count in taxels) // 4)
    wanted = {CODE: max(taxels) <= LEGIBLE, HAND: digits <= LEGIBLE, LOAD: not forces}
    headings = [name for name in (TIME, "finger", CODE, HAND, "meaning", LOAD, LATENCY) if wanted.get(name, True)]
    for heading in headings:
        table.add_column(escape(heading), justify="right" if heading in (TIME, LATENCY) else "left")
    for event, changes in grouped(collected.events):
        what = event.meaning if changes == 1 else f"{event.meaning} ({changes} changes)"
        cells = {
            TIME: f"{event.t:.3f}", "finger": event.finger, CODE: event.code, HAND: f"{event.hand:0{digits}x}",
            "meaning": what, LOAD: _located(event.load), LATENCY: f"{event.latency * 1e6:.0f}",
        }  # fmt: skip
        table.add_row(*(cells[heading] for heading in headings))
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
    place = f"({_signed(load.x * 1e3, 2)}, {_signed(load.y * 1e3, 2)})"
    forces = " ".join(_signed(part, 3) for part in (load.Q, load.R, load.F) if np.isfinite(part))
    taxels = "1 taxel" if load.taxels == 1 else f"{load.taxels} taxels"
    return f"{place} {forces}, {load.validity.name.lower()}, {taxels}"


def _signed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:+.{digits}f}"  # no -0


def _figure(value: float | None) -> str:
    return "not valid" if value is None else f"{value:.3g}"


def _median(values: np.ndarray) -> float | None:
    valid = values[np.isfinite(values)]
    return float(np.median(valid)) if valid.size else None
