"""Tables of a run on the terminal: events, and the figures of each finger."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.support.terminal import console
from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.output.collected import Collected
from tactile.output.json_data import finger_data

if TYPE_CHECKING:  # rich is slow to import
    from rich.console import Console
    from rich.table import Table

TIME, UNTIL, FINGER, CODE, HAND, MEANING = "time [s]", "until", "finger", "code", "hand", "meaning"
LOAD, LATENCY = "load: (x, y) [mm], Q R F [N]", "latency [µs]"
WIDE = 10_000
"""Width at which the table is measured: every line fits."""
LEAST = 30
"""Least width of the meaning column before it wraps instead of being cut."""
SAID = 5
"""Largest number of program outputs shown: the last ones."""
LEGIBLE = 16
"""Largest number of taxels whose code is shown, and of hexadecimal digits of the hand's code."""


def tables(collected: Collected, arrays: tuple[TaxelArray, ...]) -> None:
    """Print the table of events and a line of figures for each finger; codes of large arrays are omitted."""
    screen = console()
    forces = all(array.quantity == "force" for array in arrays)
    _print_events(screen, collected.events, arrays, not forces)
    alone = {array.name for array in arrays if not array.shear}
    for name, facts in finger_data(collected, arrays).items():
        texture = (
            "the normal alone: no shear, no friction, no code"
            if name in alone
            else f"friction {_figure(facts['friction'])}, roughness {_figure(facts['roughness'])}"
        )
        line = f"{name}: {facts['frames']} frame{'s' * (facts['frames'] != 1)}; {texture}"
        places = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in facts["located"].items())
        screen.print(line + (f"; loads: {places}" if places and not forces else ""), highlight=False, markup=False)
        if (error := facts["error"]) is not None:
            place = f"{error['place_median_m'] * 1e3:.2g} mm, at most {error['place_max_m'] * 1e3:.2g}"
            force = f"{error['force_median_n']:.2g} N, at most {error['force_max_n']:.2g}"
            screen.print(f"{name}: error against the ground truth: {place}; {force}", highlight=False, markup=False)
    if (earlier := len(collected.outputs) - SAID) > 0:
        screen.print(f"{earlier} earlier outputs of programs not shown; --json has all", highlight=False, markup=False)
    for t, finger, name, outputs in collected.outputs[-SAID:]:
        plain = ", ".join(f"{key} {_short(value)}" for key, value in outputs.items())
        screen.print(f"{t:.3f} {finger}: {name}: {plain}", highlight=False, markup=False)
    for array in arrays:
        if (tare := collected.tare(array)) is not None:
            screen.print(f"{array.name}: tare: {tare.words}", highlight=False, markup=False)


def _print_events(screen: "Console", events: list[Event], arrays: tuple[TaxelArray, ...], located: bool) -> None:
    """Print each event in one line, or two on a narrow terminal; list the omitted columns."""
    if not events:
        screen.print("no events", highlight=False, markup=False)
        return
    taxels = [array.rows * array.cols for array in arrays]
    shear = any(array.shear for array in arrays)
    digits = -(-sum(2 * count for count in taxels) // 4)
    wanted = {CODE: max(taxels) <= LEGIBLE and shear, HAND: digits <= LEGIBLE and shear, LOAD: located}
    headings = [name for name in (TIME, UNTIL, FINGER, CODE, HAND, MEANING, LOAD, LATENCY) if wanted.get(name, True)]
    rows = [
        {
            TIME: f"{event.t:.3f}",
            UNTIL: "" if event.end is None else f"{event.end:.3f}",
            FINGER: event.finger,
            CODE: event.arrows,
            HAND: f"{event.hand:0{digits}x}",
            MEANING: event.words,
            LOAD: _located(event.load),
            LATENCY: f"{event.latency * 1e6:.0f}",
        }
        for event in events
    ]
    dropped = []
    table = _table(headings, rows)
    for heading in (HAND, LATENCY, CODE, LOAD, UNTIL):
        if screen.measure(table, options=screen.options.update(width=WIDE)).maximum <= screen.width:
            break
        if heading in headings:
            headings.remove(heading)
            if heading == LOAD:  # below the meaning
                rows = [row | {MEANING: "\n".join(filter(None, (row[MEANING], row[LOAD])))} for row in rows]
            else:
                dropped.append(heading)
            table = _table(headings, rows)
    if screen.measure(table, options=screen.options.update(width=WIDE)).maximum > screen.width:
        table = _table(headings, rows, screen.width)
    screen.print(table)
    if dropped:
        screen.print(f"columns without room: {', '.join(dropped)}; --json has all", highlight=False, markup=False)


def _table(headings: list[str], rows: list[dict[str, str]], width: int = WIDE) -> "Table":
    """Return the table of events; on a narrow terminal only the meaning is cut or wrapped."""
    from rich.table import Table  # only for people

    table = Table(title="Events", title_justify="left")
    needed = {name: max(len(name), *(len(row[name]) for row in rows), 0) for name in headings}
    room = width - sum(needed[name] + 3 for name in headings if name != MEANING) - 4
    for heading in headings:
        cut = heading == MEANING
        table.add_column(
            heading, justify="right" if heading in (TIME, UNTIL, LATENCY) else "left",
            no_wrap=not (cut and room < LEAST), overflow="fold" if cut and room < LEAST else "ellipsis",
            min_width=None if cut or width == WIDE else needed[heading],
        )  # fmt: skip
    for row in rows:
        table.add_row(*(row[heading] for heading in headings))
    return table


def _located(load: Load | None) -> str:
    """Return the position of a load and its certainty; unknown components become ?."""
    if load is None or not np.isfinite(load.F):
        return "" if load is None else load.validity.name.lower().replace("_", " ")
    place = f"({_signed(load.x * 1e3, 2)}, {_signed(load.y * 1e3, 2)})"
    forces = " ".join(_signed(part, 3) if np.isfinite(part) else "?" for part in (load.Q, load.R, load.F))
    taxels = "1 taxel" if load.taxels == 1 else f"{load.taxels} taxels"
    return f"{place} {forces}, {load.validity.name.lower().replace('_', ' ')}, {taxels}"


def _short(value: Any) -> str:
    values = np.asarray(value)
    if values.ndim == 0:
        return f"{values.item()}"
    return f"on {int(values.sum())} taxels" if values.dtype == bool else f"{values.min():.3g} to {values.max():.3g}"


def _signed(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:+.{digits}f}"  # no -0


def _figure(value: float | None) -> str:
    return "not valid" if value is None else f"{value:.3g}"
