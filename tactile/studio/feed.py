"""Feed: runs the pipeline on a source in a thread of its own, and keeps the newest reports for the pages.

The thread appends and replaces lists, and pages read them, so that it never waits for a page.
"""

import threading
import time
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import InputError
from tactile import pipeline
from tactile.calibration.live_tare import LiveTare
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y, Frame, Quantity
from tactile.core.source import FrameStream, Source, provenance, with_frames
from tactile.events.event import Event
from tactile.finger import Finger
from tactile.pipeline import FrameReport, Sink
from tactile.settings import Settings
from tactile.studio.event_log import Log, noted
from tactile.thresholds.threshold import CONTACT, SHEAR

MOST_BYTES = 256 * 2**20
"""Memory for the reports of all fingers."""
LIVE_SECONDS = 60.0
"""Time that is kept of a port."""
MARK_SECONDS = 0.5
"""Least time between marks."""
MOST_AGAIN = 8000
"""Frames that are computed again at most, which takes about two seconds."""
_COST = 4096
"""Bytes of a report without its planes."""


class Kept(NamedTuple):
    """A ``report`` with its ``number`` over all fingers, the frame before the tare and the tares requested with it.

    ``outputs``: the newest outputs of users' programs on this finger.
    """

    number: int
    t: float
    report: FrameReport
    raw: Frame
    asked: tuple[bool, ...]
    outputs: Mapping[str, Mapping[str, Any]]


class Mark(NamedTuple):
    """The ``tares`` of all fingers before the report of a ``number``, while nothing is in contact."""

    number: int
    t: float
    tares: list[LiveTare]


class Feed:
    """The reports of a source; ``live``: it is a port, of which the oldest are dropped.

    ``failure`` is the message of an error that ended it; ``full``: memory ended it, as for long recordings. ``over``:
    no more reports come. ``computed``: when `again` ended (`time.monotonic`), infinite while it computes.
    ``compiling``: all loops are compiled before the first frame, and it is true until then.
    """

    def __init__(
        self, source: Source, settings: Settings, *, live: bool = False, fingers: list[Finger] | None = None,
        sinks: Iterable[Sink] = (), compiling: bool = False,
    ) -> None:  # fmt: skip
        self.source, self.settings, self.live = source, settings.of(source), live
        self.arrays, self.failure, self.full = source.arrays, "", False
        self._stopped, self.computed, self.compiling = False, float("-inf"), compiling
        self._fingers = fingers or pipeline.make_fingers(source.arrays, source.modulus, self.settings)
        self._sinks = sinks
        self.rows: list[list[Kept]] = [[] for _ in self.arrays]
        self.marks = [Mark(0, 0.0, [deepcopy(finger.tare) for finger in self._fingers])]
        self.events = Log()
        self._peaks: dict[tuple[int, Quantity], Any] = {}
        self._outputs: list[dict[str, Mapping[str, Any]]] = [{} for _ in self.arrays]
        self._raw: tuple[Frame, tuple[bool, ...]] | None = None
        self._touching = [False] * len(self.arrays)
        self._count = self._first = 0
        taxels = max(array.rows * array.cols for array in self.arrays)
        self.most = max(1000, MOST_BYTES // (len(self.arrays) * (_COST + 80 * taxels)))
        self._thread = threading.Thread(target=self._run, name="feed", daemon=True)

    def start(self) -> None:
        """Begin to take frames of the source."""
        self._thread.start()

    def stop(self) -> None:
        """Stop taking frames, including those already queued."""
        self._stopped = True
        self.wait()

    def wait(self) -> None:
        """Wait until the source has ended."""
        self._thread.join()

    @property
    def over(self) -> bool:
        """Whether no more reports come."""
        return self._thread.ident is not None and not self._thread.is_alive()

    def _run(self) -> None:
        try:
            if self.compiling:
                pipeline.warm_up(self.arrays, self.source.modulus, self.settings)
                self.compiling = False
            pipeline.run(
                with_frames(self.source, self._frames()), self.settings, [self._take, *self._sinks], self._fingers
            )
        except InputError as error:
            self.failure = str(error)
        except Exception as error:  # a page shows it; the thread has nobody else to report to
            self.failure = f"{type(error).__name__}: {error}"

    def _frames(self) -> Iterator[Frame]:
        requests: Iterable[bool] = getattr(self.source, "tare_requests", ())
        for raw in self.source:
            if self.full or self._stopped:
                return
            self._raw = raw, tuple(requests)
            yield raw

    def _take(self, report: FrameReport) -> None:
        assert self._raw is not None
        raw, asked = self._raw
        t, finger = raw.t, raw.finger
        if report.outputs:
            self._outputs[finger] = {**self._outputs[finger], **report.outputs}
        rows = self.rows[finger]
        rows.append(Kept(self._count, t, report, raw, asked, self._outputs[finger]))
        self._count += 1
        noted(self.events, report)
        peak = self._peaks.setdefault((int(t), report.array.quantity), np.zeros(2))
        if report.frame.whole or report.frame.valid.any():
            values = report.frame.values if report.frame.whole else report.frame.values[report.frame.valid]
            shear = np.hypot(values[..., SHEAR_X], values[..., SHEAR_Y]).max()
            peak[:] = np.maximum(peak, (np.abs(values[..., NORMAL]).max(), shear))
        self._touching[finger] = bool(report.code.contact.any())
        if t - self.marks[-1].t >= MARK_SECONDS and not any(self._touching):
            self.marks.append(Mark(self._count, t, [deepcopy(one.tare) for one in self._fingers]))
        if len(rows) > self.most and not self.live:
            self.full = True
        elif self.live and len(rows) % 256 == 0:
            self._drop(finger, t)

    def _drop(self, finger: int, t: float) -> None:
        """Drop the oldest of a finger, an eighth of them at least."""
        rows = self.rows[finger]
        cut = max(bisect_left(rows, t - LIVE_SECONDS, key=_time), len(rows) - self.most)
        if cut <= len(rows) // 8:
            return
        self.rows[finger] = rows = rows[cut:]
        oldest = rows[0].t
        self.events = {key: one for key, one in self.events.items() if one.end is None or one.end >= oldest}
        self._peaks = {key: peak for key, peak in self._peaks.items() if key[0] >= int(oldest)}
        self._first = max(self._first, rows[0].number)
        before = bisect_right(self.marks, self._first, key=_number) - 1  # its tare holds for the oldest that are kept
        self.marks = self.marks[max(0, before) :]

    @property
    def no_idle_start(self) -> str:
        """Why frames from now on do not begin with idle ones, from which a replay takes its tare; "" if they do."""
        if not provenance(self.source).untared:
            return ""
        untared = any(rows and not rows[-1].report.frame.valid.any() for rows in self.rows)
        return "in contact" if any(self._touching) else "not tared yet" if untared else ""

    @property
    def times(self) -> tuple[float, float] | None:
        """First and last time that is kept [s]; None before the first report."""
        ends = [(rows[0].t, rows[-1].t) for rows in self.rows if rows]
        return (min(t for t, _ in ends), max(t for _, t in ends)) if ends else None

    def at(self, t: float) -> list[Kept | None]:
        """Return the newest report of each finger at a time; None before its first."""
        found = [(rows, bisect_right(rows, t, key=_time)) for rows in self.rows]
        return [rows[place - 1] if place else None for rows, place in found]

    def between(self, finger: int, begin: float, end: float, most: int) -> list[Kept]:
        """Return reports of a finger in a time, evenly thinned out to at most ``most`` intervals."""
        rows = self.rows[finger]
        first, last = bisect_left(rows, begin, key=_time), bisect_right(rows, end, key=_time)
        every = max(1, -(-(last - first) // most))
        return rows[-(-first // every) * every : last : every]

    def events_between(self, begin: float, end: float) -> list[Event]:
        """Return the events that last at some time between two, sorted by onset."""
        return _within(list(self.events.values()), begin, end)

    def largest(self, quantity: Quantity) -> tuple[float, float]:
        """Return the largest normal and shear of a taxel in the time that is kept, at least the default thresholds."""
        peaks = [peak for (_, one), peak in list(self._peaks.items()) if one == quantity]
        normal, shear = np.max([(CONTACT[quantity].dead_band, SHEAR[quantity].dead_band), *peaks], axis=0)
        return float(normal), float(shear)

    def again(self, settings: Settings, begin: float, end: float) -> list[Event]:
        """Return the events between two times with other settings, with the tare as it was.

        The pipeline runs again from the last kept moment before ``begin`` at which nothing was in contact.
        """
        marks, latest = self.marks, max((rows[-1].number for rows in self.rows if rows), default=0)
        idle = next((one.number for one in reversed(marks) if one.t <= begin), 0)
        first = max(idle, self._first, latest - MOST_AGAIN)
        tares = next((one for one in reversed(marks) if one.number <= first), marks[0]).tares
        parts = (part[bisect_left(part, first, key=_number) : bisect_right(part, end, key=_time)] for part in self.rows)
        rows = sorted((row for part in parts for row in part), key=_number)
        fingers = pipeline.make_fingers(self.arrays, self.source.modulus, settings)
        for finger, tare in zip(fingers, tares, strict=True):
            finger.tare = deepcopy(tare)
        requests, log = deque[bool](), Log()

        def frames() -> Iterator[Frame]:
            for row in rows:
                requests.extend(row.asked)
                yield row.raw

        source = FrameStream("again", self.arrays, self.source.modulus, None, frames(), tare_requests=requests)
        self.computed = float("inf")
        try:
            pipeline.run(source, settings, [partial(noted, log)], fingers)
        finally:
            self.computed = time.monotonic()
        return _within(log.values(), begin, end)


def _time(row: Kept) -> float:
    return row.t


def _number(row: Kept | Mark) -> int:
    return row.number


def _within(events: Iterable[Event], begin: float, end: float) -> list[Event]:
    lasting = (one for one in events if one.t <= end and (one.end is None or one.end >= begin))
    return sorted(lasting, key=lambda one: one.t)
