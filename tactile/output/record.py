"""Record of a run: frames.csv (and optionally frames.parquet), a row per frame, and events.json."""

import csv
import json
import math
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from cnnsim.support.extras import need
from cnnsim.support.files import make_folder, write_text, writing
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y, TaxelArray
from tactile.events.event import EventLog
from tactile.events.phases import phases
from tactile.inverse.load import Load
from tactile.output.collected import texture_mean, total
from tactile.output.event_data import INLINE, EventData
from tactile.output.ground_truth import GroundTruth
from tactile.pipeline import FrameReport

COLUMNS = (
    "t_s", "finger", "sequence", "shear_x", "shear_y", "normal", "code", "load_x_m", "load_y_m", "load_q_n", "load_r_n",
    "load_f_n", "load_validity", "load_taxels", "load_misfit", "load_sigma_x_m", "load_sigma_y_m", "load_sigma_q_n",
    "load_sigma_r_n", "load_sigma_f_n", "load_others", "friction", "roughness", "events",
)  # fmt: skip

TRUE_COLUMNS = (
    "true_loads", "true_x_m", "true_y_m", "true_q_n", "true_r_n", "true_f_n", "error_m", "error_n",
)  # fmt: skip
"""Additional columns for scenes with ground truth."""
KINDS = dict.fromkeys(("finger", "code", "load_validity", "load_others", "events"), str) | dict.fromkeys(
    ("sequence", "load_taxels", "true_loads"), int
)
"""Types of the text and integer columns; others are floating point."""
FORMULA = tuple("=+-@\t\r")
"""First characters of cells that a spreadsheet evaluates."""


def text_cell(text: str, *, always: bool = False) -> str:
    """Return a text as a cell that a spreadsheet takes for text: with a leading apostrophe.

    Only for texts that begin like a formula, unless ``always``: a code such as -0+0 or 0000.
    """
    return f"'{text}" if always or text[:1] in FORMULA else text


class RunRecord:
    """A sink that writes frames.csv as frames come, and events.json (with the settings) at the end.

    ``parquet``: also write frames.parquet, with texts without apostrophes.

    Raises:
        InputError: a file cannot be written, or the Parquet library is not installed.
    """

    def __init__(
        self, folder: Path, arrays: tuple[TaxelArray, ...], provenance: dict[str, Any],
        truth: GroundTruth | None = None, *, parquet: bool = False,
    ) -> None:  # fmt: skip
        self._folder, self._provenance, self._plain = folder, provenance, EventData(arrays)
        self._log = EventLog()
        self._arrays, self._span = arrays, {array.name: [math.inf, -math.inf] for array in arrays}
        self._codes: dict[str, str] = {}
        self._truth = truth
        self._tares: dict[str, dict[str, Any]] = {}
        make_folder(folder)
        columns = COLUMNS + (TRUE_COLUMNS if truth is not None else ())
        self._rows: Any = None
        with ExitStack() as whole:
            if parquet:
                rows = need("tactile.recording.parquet_rows", "a Parquet table")
                beside = whole.enter_context(writing(folder / "frames.parquet", follow=False))
                kinds = {name: KINDS.get(name, float) for name in columns}
                self._rows = whole.enter_context(rows.ParquetRows(beside, kinds))
            beside = whole.enter_context(writing(folder / "frames.csv", follow=False))
            file = whole.enter_context(beside.open("w", newline="", encoding="utf-8"))
            self._csv = csv.writer(file)
            self._csv.writerow(columns)
            self._whole = whole.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, OSError):  # incomplete files are removed
            self._whole.__exit__(kind, error, trace)
            return
        self._whole.close()
        record = {**self._provenance, "complete": kind is None, "tares": self._tares}
        found = self._log.events
        record["phases"] = {
            name: [phase._asdict() for phase in phases(found, name, *span)]
            for name, span in self._span.items() if span[0] <= span[1]
        }  # fmt: skip
        head = json.dumps(record, indent=1, ensure_ascii=False).removesuffix("\n}")
        # one line, one event
        events = ",\n  ".join(json.dumps(self._plain(event), ensure_ascii=False) for event in found)
        text = f'{head},\n "events": [\n  {events}\n ]\n}}\n'
        write_text(self._folder / "events.json", text, follow=False)

    def __call__(self, report: FrameReport) -> None:
        """Write one report."""
        self._log.add(report.events, report.ended)
        span = self._span[report.array.name]
        span[0], span[1] = min(span[0], report.frame.t), max(span[1], report.frame.t)
        if report.tare is not None:
            self._tares[report.array.name] = report.tare.plain()
        load, texture, frame = report.load, report.texture, report.frame
        located = (load.x, load.y, load.Q, load.R, load.F, load.validity.name.lower(), load.taxels, load.misfit)
        spread, others = load.sigma, "; ".join(_words(other) for other in load.others)
        code = self._code(report)
        happened = "; ".join(event.words for event in report.events)
        figures = total(report, SHEAR_X), total(report, SHEAR_Y), total(report, NORMAL)
        felt = texture_mean(texture.friction, texture.valid), texture_mean(texture.roughness, texture.valid)
        true = () if self._truth is None else self._truth(report)
        name, cell = report.array.name, "" if code is None else text_cell(code, always=True)
        beside, told = text_cell(others), text_cell(happened)
        self._csv.writerow(
            (frame.t, text_cell(name), frame.sequence, *figures, cell, *located, *spread, beside, *felt, told, *true)
        )
        if self._rows is not None:
            self._rows(frame.t, name, frame.sequence, *figures, code, *located, *spread, others, *felt, happened, *true)

    def _code(self, report: FrameReport) -> str | None:
        """Return the ternary code; for a large array None if it is unchanged."""
        name, code = report.array.name, report.code.ternary()
        if report.array.rows * report.array.cols > INLINE and self._codes.get(name) == code:
            return None
        self._codes[name] = code
        return code


def _words(load: Load) -> str:
    """Return a further load as x y [m] Q R F [N]."""
    return " ".join(f"{value:.6g}" for value in (load.x, load.y, load.Q, load.R, load.F))
