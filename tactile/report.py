"""What a run says in words: the tables on the terminal, and the same as data."""

from typing import Any

import numpy as np

from tactile.frame import TaxelArray
from tactile.inverse import Validity
from tactile.localise import Load
from tactile.sinks import Collected


def located(load: Load | None) -> str:
    """Say where a load is and how sure that is."""
    if load is None:
        return ""
    if not np.isfinite(load.F):
        return load.validity.name.lower().replace("_", " ")
    shear = "" if not np.isfinite(load.Q) else f" {load.Q:+.2f} {load.R:+.2f}"
    where = f"({load.x * 1e3:+.2f}, {load.y * 1e3:+.2f}) mm{shear} {load.F:+.2f} N"
    return f"{where} {load.validity.name.lower()}, {load.taxels} taxels"


def tables(collected: Collected, arrays: tuple[TaxelArray, ...]) -> None:
    """Print the table of events and a line of figures for each finger."""
    from rich.console import Console  # only for people
    from rich.table import Table  # the same

    console = Console(width=None if Console().is_terminal else 150)
    table = Table(title="Events", title_justify="left")
    for heading in ("time [s]", "finger", "code", "hand", "meaning", "load: place, Q R F", "latency [µs]"):
        table.add_column(heading, justify="right" if heading.endswith("]") else "left", no_wrap=heading != "meaning")
    digits = sum(array.rows * array.cols for array in arrays) * 2 // 4
    if not any(array.quantity != "force" for array in arrays):
        table.columns.pop(5)
    for event in collected.events:
        cells = [f"{event.t:.3f}", event.finger, event.code, f"{event.hand:0{digits}x}", event.meaning,
                 located(event.load), f"{event.latency * 1e6:.0f}"]  # fmt: skip
        if len(table.columns) == len(cells) - 1:
            cells.pop(5)
        table.add_row(*cells)
    console.print(table)
    for name, facts in summary(collected, arrays)["fingers"].items():
        friction, roughness = (
            "not valid" if facts[key] is None else f"{facts[key]:.3g}" for key in ("friction", "roughness")
        )
        line = f"{name}: {facts['frames']} frames, friction {friction}, roughness {roughness}"
        places = ", ".join(f"{count} {kind}" for kind, count in facts["located"].items())
        console.print(line + (f"; loads: {places}" if places else ""), highlight=False)


def summary(collected: Collected, arrays: tuple[TaxelArray, ...]) -> dict[str, Any]:
    """Return the run as plain data: events, and for each finger its frames, loads by validity and texture figures."""
    fingers = {}
    for array in arrays:
        rows = collected.table(array.name)
        kinds = {kind.name.lower(): int((rows[:, 9] == kind).sum()) for kind in Validity}
        fingers[array.name] = {
            "frames": len(rows),
            "located": {kind: count for kind, count in kinds.items() if count},
            "friction": _last(rows[:, 10]),
            "roughness": _last(rows[:, 11]),
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


def _last(values: np.ndarray) -> float | None:
    """The last figure that was valid."""
    valid = values[np.isfinite(values)]
    return float(valid[-1]) if valid.size else None
