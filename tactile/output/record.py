"""The record of a run: frames.csv, a row a frame, and events.json."""

import csv
import json
import math
from contextlib import nullcontext, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from cnnsim.support.files import make_folder, write_text, writing
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y, TaxelArray
from tactile.events.event import EventLog
from tactile.events.phases import phases
from tactile.output.collected import texture_mean, total
from tactile.output.event_data import INLINE, EventData
from tactile.output.truth import Truth
from tactile.pipeline import FrameReport

COLUMNS = (
    "t_s", "finger", "sequence", "shear_x", "shear_y", "normal", "code", "load_x_m", "load_y_m", "load_q_n", "load_r_n",
    "load_f_n", "load_validity", "load_taxels", "load_misfit", "friction", "roughness", "events",
)  # fmt: skip

TRUE_COLUMNS = (
    "true_loads", "true_x_m", "true_y_m", "true_q_n", "true_r_n", "true_f_n", "error_m", "error_n",
)  # fmt: skip
"""Further columns where a scene knows the truth."""
FORMULA = tuple("=+-@\t\r")
"""What a cell begins with that a spreadsheet computes."""


def text_cell(text: str, *, always: bool = False) -> str:
    """Return a text as a cell that a spreadsheet neither computes nor takes for a number: an apostrophe before it.

    Only where it begins as a formula does, unless ``always``: a code such as -0+0 or 0000 is a text.
    """
    return f"'{text}" if always or text[:1] in FORMULA else text


class Record:
    """A sink that writes frames.csv as the frames come, and events.json (with what made them) at the end."""

    def __init__(
        self, folder: Path, arrays: tuple[TaxelArray, ...], provenance: dict[str, Any], truth: Truth | None = None
    ) -> None:
        self._folder, self._provenance, self._plain = folder, provenance, EventData(arrays)
        self._log = EventLog()
        self._arrays, self._span = arrays, {array.name: [math.inf, -math.inf] for array in arrays}
        self._codes: dict[str, str] = {}
        self._truth = truth
        self._tares: dict[str, dict[str, Any]] = {}
        make_folder(folder)
        self._whole = writing(folder / "frames.csv", follow=False)
        self._file = self._whole.__enter__().open("w", newline="", encoding="utf-8")
        self._csv = csv.writer(self._file)
        self._csv.writerow(COLUMNS + (TRUE_COLUMNS if truth is not None else ()))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError) if isinstance(error, OSError) else nullcontext():
            self._file.close()  # a full disk says so twice
        if isinstance(error, OSError):  # what could not be written as a whole is not kept
            self._whole.__exit__(kind, error, trace)
            return
        self._whole.__exit__(None, None, None)
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
        code = self._code(report)
        happened = text_cell("; ".join(event.words for event in report.events))
        self._csv.writerow((
            frame.t, text_cell(report.array.name), frame.sequence, total(report, SHEAR_X), total(report, SHEAR_Y),
            total(report, NORMAL), code, *located, texture_mean(texture.friction, texture.valid),
            texture_mean(texture.roughness, texture.valid), happened,
            *(() if self._truth is None else self._truth(report)),
        ))  # fmt: skip

    def _code(self, report: FrameReport) -> str:
        """Return the ternary code; of a large array nothing where it is that of the frame before."""
        name, code = report.array.name, report.code.ternary()
        if report.array.rows * report.array.cols > INLINE and self._codes.get(name) == code:
            return ""
        self._codes[name] = code
        return text_cell(code, always=True)
