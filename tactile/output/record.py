"""Sinks: callables that take reports. They collect, print or write; none of them knows another."""

import csv
import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from cnnsim import InputError
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y
from tactile.events.events import Event
from tactile.pipeline import Report

COLUMNS = (
    "t_s", "finger", "sequence", "shear_x", "shear_y", "normal", "code", "load_x_m", "load_y_m", "load_q_n", "load_r_n",
    "load_f_n", "load_validity", "load_taxels", "load_residual_m", "friction", "roughness", "events",
)  # fmt: skip


def total(report: Report, axis: int) -> float:
    """Return one component summed over the valid taxels, in the unit of the array's quantity."""
    return float(report.frame.values[..., axis][report.frame.valid].sum())


def figure(plane: Any, valid: Any) -> float:
    """Return the mean of a texture figure over the taxels where it is valid; NaN where there is none."""
    return float(plane[valid].mean()) if valid.any() else float("nan")


class Collected:
    """Keeps what the table and the picture need: events, a row of numbers a frame, and the frame that pressed most."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.rows: dict[str, list[tuple[float, ...]]] = {}
        self.strongest: dict[str, np.ndarray] = {}
        self.frames = 0

    def __call__(self, report: Report) -> None:
        """Take one report."""
        self.frames += 1
        values = np.where(report.frame.valid[..., None], report.frame.values, 0.0)
        best = self.strongest.setdefault(report.array.name, values)
        if abs(values[..., NORMAL].sum()) > abs(best[..., NORMAL].sum()):
            self.strongest[report.array.name] = values
        self.events += report.events
        load, texture = report.load, report.texture
        place = (np.nan,) * 6 if load is None else (load.x, load.y, load.Q, load.R, load.F, float(load.validity))
        self.rows.setdefault(report.array.name, []).append((
            report.frame.t, total(report, SHEAR_X), total(report, SHEAR_Y), total(report, NORMAL), *place,
            figure(texture.friction, texture.valid), figure(texture.roughness, texture.valid),
        ))  # fmt: skip

    def table(self, finger: str) -> np.ndarray:
        """Return (frames, 12): t, shear_x, shear_y, normal, x, y, Q, R, F, validity, friction, roughness."""
        return np.array(self.rows.get(finger, []), dtype=np.float64).reshape(-1, 12)


class Record:
    """Writes frames.csv as the frames come, and events.json (with what made them) at the end."""

    def __init__(self, folder: Path, provenance: dict[str, Any]) -> None:
        self._folder, self._provenance = folder, provenance
        self._events: list[Event] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = (folder / "frames.csv").open("w", newline="", encoding="utf-8")
        except OSError as error:
            raise InputError(f"cannot write the record to {folder}: {error.strerror}") from error
        self._csv = csv.writer(self._file)
        self._csv.writerow(COLUMNS)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self._file.close()
        events = [
            {
                "t_s": event.t, "finger": event.finger, "sequence": event.sequence, "code": event.ternary,
                "hand": f"{event.hand:x}", "meaning": event.meaning,
            }
            for event in self._events
        ]  # fmt: skip
        record = {**self._provenance, "complete": kind is None, "events": events}
        (self._folder / "events.json").write_text(
            json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
        )

    def __call__(self, report: Report) -> None:
        """Write one report."""
        self._events += report.events
        load, texture, frame = report.load, report.texture, report.frame
        located: tuple[Any, ...] = ("",) * 8
        if load is not None:
            located = (load.x, load.y, load.Q, load.R, load.F, load.validity.name.lower(), load.taxels, load.residual)
        self._csv.writerow((
            frame.t, report.array.name, frame.sequence, total(report, SHEAR_X), total(report, SHEAR_Y),
            total(report, NORMAL), report.code.ternary(), *located, figure(texture.friction, texture.valid),
            figure(texture.roughness, texture.valid), "; ".join(event.meaning for event in report.events),
        ))  # fmt: skip
