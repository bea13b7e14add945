"""Table of the events of many recordings (CSV, Parquet): a row per event or unreadable recording.

The header of both is JSON: version, settings, units, and the status of each recording; in CSV as comment lines.
"""

import csv
import json
import math
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support.extras import need
from cnnsim.support.files import make_folder, writing
from tactile.core.frame import NORMAL, Quantity
from tactile.events.event import Event
from tactile.output.event_data import finite
from tactile.output.record import text_cell
from tactile.thresholds.levels import Levels

FORMAT = "tactile_events"
COLUMNS: Mapping[str, Any] = {
    "recording": str, "finger": str, "kind": str, "t_s": float, "end_s": float, "told_s": float, "sequence": int,
    "confidence": float, "words": str, "data": str, "taxels": str, "ternary": str, "load_x_m": float,
    "load_y_m": float, "load_q_n": float, "load_r_n": float, "load_f_n": float, "shear_off": float, "shear_on": float,
    "normal_off": float, "normal_on": float, "unit": str, "error": str,
}  # fmt: skip
"""Columns and their types; thresholds are medians over the taxels at the time of the report."""
UNITS: Mapping[Quantity, str] = {"force": "N", "strain": "1", "stress": "Pa"}
TOLD = {
    "t_s": "[s] onset, from the first frame of the recording", "end_s": "[s] end, empty while it lasts",
    "told_s": "[s] time of the deciding frame", "sequence": "of that frame", "confidence": "[1]",
    "data": "JSON; names end in their SI unit", "taxels": "row.col of the taxels",
    "ternary": "code of the finger: -0+ for x and y of each taxel",
    "load_x_m": "[m]", "load_y_m": "[m]", "load_q_n": "[N] along x", "load_r_n": "[N] along y",
    "load_f_n": "[N] pressing", "shear_off": "a direction ends below it, in unit", "shear_on": "and begins above it",
    "normal_off": "contact ends below it, in unit", "normal_on": "and begins above it",
    "error": "reason why a recording has no events",
}  # fmt: skip
"""Descriptions of the columns for the header."""


def event_row(recording: str, event: Event, levels: Levels | None, quantity: Quantity | None) -> dict[str, Any]:
    """Return an event as a row; ``levels`` and ``quantity`` are those of its finger, None for events of the hand."""
    load = event.load
    row: dict[str, Any] = {
        "recording": recording, "finger": event.finger, "kind": event.kind, "t_s": event.t, "end_s": event.end,
        "told_s": finite(event.told), "sequence": event.sequence, "confidence": event.confidence,
        "words": event.words, "data": json.dumps(dict(event.data), ensure_ascii=False),
        "taxels": " ".join(f"{row}.{col}" for row, col in event.taxels), "ternary": event.ternary,
    }  # fmt: skip
    if load is not None:
        row |= {f"load_{name.lower()}_{unit}": finite(getattr(load, name)) for name, unit in (
            ("x", "m"), ("y", "m"), ("Q", "n"), ("R", "n"), ("F", "n")
        )}  # fmt: skip
    if levels is not None and quantity is not None:
        for name, part in (("shear", slice(0, NORMAL)), ("normal", slice(NORMAL, NORMAL + 1))):
            row |= {f"{name}_off": float(np.median(levels.off[..., part]))}
            row |= {f"{name}_on": float(np.median(levels.on[..., part]))}
        row["unit"] = UNITS[quantity]
    return row


def write_events(folder: Path, rows: Iterable[Mapping[str, Any]], head: Mapping[str, Any], *, parquet: bool) -> None:
    """Write events.csv, and events.parquet if wanted, into a folder.

    Raises:
        InputError: a file cannot be written, or pyarrow is wanted and not installed.
    """
    make_folder(folder)
    with ExitStack() as whole:
        into: Any = None
        if parquet:
            writer = need("tactile.recording.parquet_rows", "a Parquet table").ParquetRows
            beside = whole.enter_context(writing(folder / "events.parquet", follow=False))
            text = json.dumps({FORMAT: 1, **head}, ensure_ascii=False)
            into = whole.enter_context(writer(beside, COLUMNS, {b"tactile": text.encode()}))
        beside = whole.enter_context(writing(folder / "events.csv", follow=False))
        file = whole.enter_context(beside.open("w", newline="", encoding="utf-8"))
        for name, value in ({FORMAT: 1} | dict(head)).items():
            file.write(f"# {name} = {json.dumps(value, ensure_ascii=False)}\n")
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for row in rows:
            table.writerow([_cell(name, row.get(name)) for name in COLUMNS])
            if into is not None:
                into(*(row.get(name) for name in COLUMNS))


def _cell(name: str, value: Any) -> Any:
    if isinstance(value, str):
        return text_cell(value, always=name == "ternary" and bool(value))
    return "" if value is None or (isinstance(value, float) and not math.isfinite(value)) else value
