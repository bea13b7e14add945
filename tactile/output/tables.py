"""Tables of a run on the terminal: the events, and the figures of each finger."""

from collections.abc import Iterable

import numpy as np

from cnnsim.support.echo import console
from tactile.core.frame import TaxelArray
from tactile.events.contact_and_shear import TouchKind
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.output.collected import Collected
from tactile.output.json_data import run_data

TIME, CODE, HAND, LOAD, LATENCY = "time [s]", "code", "hand", "load: (x, y) [mm], Q R F [N]", "latency [µs]"
LEGIBLE = 16
"""Most taxels of an array whose code is in the table, and most hexadecimal digits of the hand's code."""
PATTERNS = frozenset(TouchKind) - {TouchKind.CONTACT, TouchKind.RELEASE}
"""Kinds of event that come in quick succession: changes of the taxels' code while they touch."""
TOGETHER = 0.05
"""[s] Events of these kinds of one finger that follow each other faster than this are one line of the table."""


def tables(collected: Collected, arrays: tuple[TaxelArray, ...]) -> None:
    """Print the table of events and a line of figures for each finger; codes of many taxels are left to the record."""
    from rich.table import Table  # only for people

    screen = console()
    forces = all(array.quantity == "force" for array in arrays)
    table = Table(title="Events", title_justify="left")
    taxels = [array.rows * array.cols for array in arrays]
    digits = -(-sum(2 * count for count in taxels) // 4)
    wanted = {CODE: max(taxels) <= LEGIBLE, HAND: digits <= LEGIBLE, LOAD: not forces}
    headings = [name for name in (TIME, "finger", CODE, HAND, "meaning", LOAD, LATENCY) if wanted.get(name, True)]
    for heading in headings:
        table.add_column(heading, justify="right" if heading in (TIME, LATENCY) else "left")
    for event, changes in grouped(collected.events):
        what = event.words if changes == 1 else f"{event.words} ({changes} changes)"
        cells = {
            TIME: f"{event.t:.3f}", "finger": event.finger, CODE: event.arrows, HAND: f"{event.hand:0{digits}x}",
            "meaning": what, LOAD: _located(event.load), LATENCY: f"{event.latency * 1e6:.0f}",
        }  # fmt: skip
        table.add_row(*(cells[heading] for heading in headings))
    screen.print(table)
    for name, facts in run_data(collected, arrays)["fingers"].items():
        texture = f"friction {_figure(facts['friction'])}, roughness {_figure(facts['roughness'])}"
        line = f"{name}: {facts['frames']} frames; {texture}"
        places = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in facts["located"].items())
        screen.print(line + (f"; loads: {places}" if places and not forces else ""), highlight=False, markup=False)
    for array in arrays:
        if (tare := collected.tare(array)) is not None:
            screen.print(f"{array.name}: tare: {tare.words}", highlight=False, markup=False)


def grouped(events: Iterable[Event]) -> list[tuple[Event, int]]:
    """Return the events in the order of time, quick successions of `PATTERNS` as the last one and their number."""
    lines: list[tuple[Event, int]] = []
    open_line: dict[str, int] = {}
    for event in events:
        pattern = event.kind in PATTERNS
        at = open_line.get(event.finger)
        if pattern and at is not None and event.t - lines[at][0].t <= TOGETHER:
            lines[at] = (event, lines[at][1] + 1)
            continue
        open_line.pop(event.finger, None)
        if pattern:
            open_line[event.finger] = len(lines)
        lines.append((event, 1))
    return sorted(lines, key=lambda line: line[0].t)


def _located(load: Load | None) -> str:
    """Say where a load is and how sure that is."""
    if load is None or not np.isfinite(load.F):
        return "" if load is None else load.validity.name.lower().replace("_", " ")
    place = f"({_signed(load.x * 1e3, 2)}, {_signed(load.y * 1e3, 2)})"
    forces = " ".join(_signed(part, 3) for part in (load.Q, load.R, load.F) if np.isfinite(part))
    taxels = "1 taxel" if load.taxels == 1 else f"{load.taxels} taxels"
    return f"{place} {forces}, {load.validity.name.lower().replace('_', ' ')}, {taxels}"


def _signed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:+.{digits}f}"  # no -0


def _figure(value: float | None) -> str:
    return "not valid" if value is None else f"{value:.3g}"
