"""Episode of a learning set: the tared samples of a recording at a fixed frame rate, with codes and labels."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats, InputError, Integers
from tactile import pipeline
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import with_frames
from tactile.events.event import Event, EventLog
from tactile.events.phases import APPROACH, HOLD, LOAD, RELEASE, SLIP, TANGENTIAL, UNLOAD, phases
from tactile.export.tared import open_for_export
from tactile.layout.layout import Layout
from tactile.pipeline import FrameReport

PHASES = (APPROACH, LOAD, HOLD, TANGENTIAL, SLIP, UNLOAD, RELEASE)
"""Phases by their number in a learning set."""
SLIPS = ("none", "incipient_slip", "slip")
"""Kinds of slip by their number."""
Watch = Callable[[Iterable[Frame], int | None], Iterable[Frame]]
Column = NDArray[Any]


class Track:
    """The samples of one finger: times [s], values, validity, and code (x, y, contact) of every taxel."""

    def __init__(self, array: TaxelArray) -> None:
        self._rows: list[tuple[float, Column, Column, Column]] = []
        self.array = array

    def add(self, report: FrameReport) -> None:
        """Add a report."""
        frame, code = report.frame, report.code
        valid = frame.valid & np.isfinite(frame.values).all(-1)
        values = np.where(valid[..., None], frame.values, 0.0).astype(np.float32).reshape(-1, 3)
        planes = np.stack((code.x, code.y, code.contact), -1).astype(np.int8).reshape(-1, 3)
        self._rows.append((frame.t, values, valid.reshape(-1), planes))

    def columns(self) -> tuple[Floats, Column, Column, Column]:
        """Return the times (n,), values (n, taxels, 3), validity (n, taxels) and codes (n, taxels, 3)."""
        t, values, valid, code = zip(*self._rows, strict=True)
        return np.array(t), np.array(values), np.array(valid), np.array(code)


def longest_window(times: Iterable[Sequence[float]], fps: int) -> int:
    """Return the largest number of samples of a finger within any interval of 1 / fps."""
    sorted_ = [np.array(one) for one in times if len(one)]
    return max(int((np.searchsorted(t, t + 1 / fps - 1e-9) - np.arange(t.size)).max()) for t in sorted_)


def episode(
    path: Path, fps: int, window: int, watch: Watch, layout: Layout | None = None
) -> tuple[dict[str, Column], float]:  # fmt: skip
    """Return the columns of an episode by feature, each (frames, ...), and the time [s] of its first frame.

    Frame k is at t0 + k / fps. t0 is the first time at which every finger has a tared sample. A finger's observation is
    its latest sample; ``window``: the samples since the frame before, the last one repeated to the fixed length.

    Raises:
        InputError: it cannot be opened, or a finger has no tared sample.
    """
    opened, log = open_for_export(path, layout), EventLog()
    source = opened.source
    tracks = {array.name: Track(array) for array in source.arrays}
    for report in pipeline.reports(with_frames(source, watch(source, source.frames)), opened.settings):
        tracks[report.array.name].add(report)
        log.add(report.events, report.ended)
    read = {name: track.columns() for name, track in tracks.items()}
    for name, (_, _, valid, _) in read.items():
        if not valid.any():
            raise InputError(
                f"{path}: finger {name!r}: no tared sample, so no episode; idle frames at the start wanted"
            )
    first = max(float(t[valid.any(-1).argmax()]) for t, _, valid, _ in read.values())
    last = min(float(t[-1]) for t, *_ in read.values())
    frames = max(int((last - first) * fps + 1e-6), 0) + 1
    at = first + np.arange(frames) / fps
    columns: dict[str, Column] = {}
    for name in tracks:
        columns |= dict(_finger(name, read[name], at, window))
        columns |= dict(_labels(name, log.events, at))
    return columns, first


def _finger(name: str, read: tuple[Column, ...], at: Floats, window: int) -> Iterator[tuple[str, Column]]:
    t, values, valid, code = read
    index: Integers = np.searchsorted(t, at + 1e-9, "right") - 1
    step = at[1] - at[0] if at.size > 1 else 0.0
    begin = np.concatenate(([np.searchsorted(t, at[0] - step + 1e-9, "right")], index[:-1] + 1))
    since = np.minimum(begin[:, None] + np.arange(window), index[:, None])
    key = f"observation.tactile.{name}"
    yield key, values[index]
    yield f"{key}.window", values[since]
    yield f"{key}.window_count", np.minimum(index - begin + 1, window)
    yield f"{key}.valid", valid[index]
    yield f"{key}.code", code[index]


def _labels(name: str, events: Sequence[Event], at: Floats) -> Iterator[tuple[str, Column]]:
    """Yield slip and phase of each frame; they need the whole recording, so they are labels, no observations."""
    slip, phase = np.zeros(at.size, np.int64), np.zeros(at.size, np.int64)
    for number, kind in enumerate(SLIPS):
        for event in events:
            if (event.finger, event.kind) == (name, kind):
                slip[(event.t <= at) & (at < (np.inf if event.end is None else event.end))] = number
    for part in phases(events, name, float(at[0]), float(at[-1])):
        phase[part.start <= at] = PHASES.index(part.phase)
    yield f"annotation.tactile.{name}.slip", slip
    yield f"annotation.tactile.{name}.phase", phase
