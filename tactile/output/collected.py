"""A run collected in memory: its events, the figures of every frame as columns, and the strongest frame."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats
from tactile.calibration.tare_check import TareCheck, TareNote
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y, TaxelArray
from tactile.events.event import Event, EventLog
from tactile.output.ground_truth import GroundTruth
from tactile.pipeline import FrameReport

LATE = 2
"""Number of tare lengths without a reading after which the delay is reported."""
SMOOTH = 10
"""Number of frames averaged before readings count as below the tare."""


class Columns(NamedTuple):
    """The figures of the frames of one finger, each (frames,).

    ``t`` [s]; ``shear_x``, ``shear_y``, ``normal``: sums over the valid taxels, in the unit of the quantity, NaN
    without any; ``x``, ``y`` [m], ``Q``, ``R``, ``F`` [N] and ``validity`` of the located or summed load; ``friction``,
    ``roughness``: means over the taxels where they are valid, NaN without any.
    """

    t: Floats
    shear_x: Floats
    shear_y: Floats
    normal: Floats
    x: Floats
    y: Floats
    Q: Floats
    R: Floats
    F: Floats
    validity: Floats
    friction: Floats
    roughness: Floats


class ProgramOutput(NamedTuple):
    """Changed outputs of a user's program: time [s], finger, name of the program, planes or numbers by name."""

    t: float
    finger: str
    program: str
    outputs: dict[str, Any]


def total(report: FrameReport, axis: int) -> float:
    """Return one component summed over the valid taxels, in the unit of the quantity; NaN without any."""
    valid = report.frame.valid
    return float(report.frame.values[..., axis][valid].sum()) if valid.any() else float("nan")


def texture_mean(plane: Any, valid: Any) -> float:
    """Return the mean of a texture figure over its valid taxels; NaN without any."""
    return float(plane[valid].mean()) if valid.any() else float("nan")


class Collected:
    """A sink that collects the data of the tables and the plot."""

    def __init__(self, truth: GroundTruth | None = None) -> None:
        self._truth = truth
        self._errors: dict[str, list[tuple[float, float]]] = {}
        self._log = EventLog()
        self.notes: list[TareNote] = []
        self.outputs: list[ProgramOutput] = []
        self.strongest: dict[str, Floats] = {}
        self._sums: dict[str, float] = {}
        self.dead_bands: dict[str, float] = {}
        self._tares: dict[str, TareCheck] = {}
        self._moved: set[str] = set()
        self.frames = 0
        self._rows: dict[str, list[tuple[float, ...]]] = {}
        self._others: dict[str, list[tuple[float, float, float, float]]] = {}

    def __call__(self, report: FrameReport) -> None:
        """Process one report."""
        self.frames += 1
        self._firmest(report)
        self.take(report.events, report.ended)
        self.notes += report.tares
        if any(note.notice and note.offset is not None for note in report.tares):
            self._moved.add(report.array.name)
        where = report.frame.t, report.array.name
        self.outputs += [ProgramOutput(*where, name, dict(out)) for name, out in report.outputs.items()]
        if report.tare is not None:
            self._tares[report.array.name] = report.tare
        load, texture = report.load, report.texture
        if self._truth is not None:
            true = self._truth(report)
            self._errors.setdefault(report.array.name, []).append((true.error_m, true.error_n))
        if load.others:
            more = [(report.frame.t, other.x, other.y, other.F) for other in load.others]
            self._others.setdefault(report.array.name, []).extend(more)
        place = load.x, load.y, load.Q, load.R, load.F, float(load.validity)
        self._rows.setdefault(report.array.name, []).append((
            report.frame.t, total(report, SHEAR_X), total(report, SHEAR_Y), total(report, NORMAL), *place,
            texture_mean(texture.friction, texture.valid), texture_mean(texture.roughness, texture.valid),
        ))  # fmt: skip

    def _firmest(self, report: FrameReport) -> None:
        """Keep the frame with the largest normal sum, with NaN for invalid taxels."""
        name, sum_ = report.array.name, abs(total(report, NORMAL))
        if not sum_ > self._sums.get(name, -1.0):  # NaN: no reading at all
            return
        self._sums[name] = sum_
        self.strongest[name] = np.where(report.frame.valid[..., None], report.frame.values, np.nan)
        if report.levels is not None:
            self.dead_bands[name] = float(np.median(report.levels.off[..., :NORMAL]))

    def take(self, begun: Iterable[Event], ended: Iterable[Event]) -> None:
        """Add events that begin and events that end."""
        self._log.add(begun, ended)

    @property
    def events(self) -> list[Event]:
        """All events, sorted by onset; those that ended have their end."""
        return self._log.events

    def columns(self, finger: str) -> Columns:
        """Return the figures of the frames of one finger."""
        rows = np.array(self._rows.get(finger, []), dtype=np.float64).reshape(-1, len(Columns._fields))
        return Columns(*rows.T)

    def others(self, finger: str) -> Floats:
        """Return (loads, 4): time [s], position (x, y) [m] and force F [N] of further loads."""
        return np.array(self._others.get(finger, []), dtype=np.float64).reshape(-1, 4)

    def errors(self, finger: str) -> Floats:
        """Return (frames, 2): distance of the located load from the true one [m], and error of its force [N].

        NaN without a located or true load; no rows for sources without ground truth.
        """
        return np.array(self._errors.get(finger, []), dtype=np.float64).reshape(-1, 2)

    def tare(self, array: TaxelArray) -> TareCheck | None:
        """Return the offsets of the tare of a finger, checked against later readings; None without a tare."""
        check = self._tares.get(array.name)
        if check is None:
            return None
        columns = self.columns(array.name)
        known = np.flatnonzero(np.isfinite(columns.normal))
        if known.size and known[0] > LATE * check.frames:
            check = replace(check, late=float(columns.t[known[0]] - columns.t[0]))
        if array.name in self._moved:
            return check  # its zero moved, which is reported
        normal = columns.normal[check.frames :]
        normal = normal[np.isfinite(normal)]
        if normal.size < SMOOTH:
            return check
        pressing = normal if array.quantity == "force" else -normal
        smooth = np.convolve(pressing, np.full(SMOOTH, 1 / SMOOTH), "valid")
        return check.then(float(smooth.min()), array.rows * array.cols)

    @property
    def seconds(self) -> float:
        """Longest time [s] from the first to the last frame of a finger."""
        return max((rows[-1][0] - rows[0][0] for rows in self._rows.values()), default=0.0)
