"""The pipeline on a port, or on a recording of one: what is watched, printed and kept of it."""

import json
import math
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from tactile import pipeline
from tactile.calibration.live_tare import LiveTare, TareNote
from tactile.cli.meter import Meter
from tactile.core.frame import TaxelArray
from tactile.events.code import SIGN, Threshold
from tactile.events.events import Event
from tactile.finger import Settings
from tactile.pipeline import Report
from tactile.wire.source import Chunk, WireSource, tares_for

if TYPE_CHECKING:
    from tactile.calibration.file import Calibration

AUTO, MANUAL, OFF = "auto", "manual", "off"
EVENTS_KEPT = 12
STATUS = 10**9
"""[ns] from one status to the next."""


@dataclass(frozen=True)
class Choices:
    """What a user chose for the pipeline; a recording keeps it, so that a replay runs alike.

    ``calibration`` is the text of a calibration's file.
    """

    tare: str = AUTO
    dead_band: float | None = None
    hysteresis: float | None = None
    sign_code: bool = False
    window: int = 128
    floor: float | None = None
    backend: str = "cpu"
    program: str | None = None
    calibration: str | None = None

    def settings(self, arrays: Iterable[TaxelArray]) -> Settings:
        """Return the pipeline's settings for arrays; the tare and the description's gains come before the pipeline.

        Raises:
            InputError: a wrong calibration, or one of strain for an array of something else.
        """
        shear = SIGN if self.sign_code else None
        if self.dead_band is not None:
            shear = Threshold(self.dead_band, self.dead_band / 2 if self.hysteresis is None else self.hysteresis)
        settings = Settings(shear, window=self.window, floor=self.floor, backend=self.backend)
        made = self._calibration
        return settings if made is None else made.applied(settings, arrays)

    def tares(self, arrays: tuple[TaxelArray, ...]) -> tuple[LiveTare, ...]:
        """Return each finger's tare, which sees readings that the calibration's gains are still to come to."""
        made = self._calibration
        return () if self.tare == OFF else tares_for(arrays, self.tare == AUTO, made.gains if made else None)

    @property
    def _calibration(self) -> "Calibration | None":
        if self.calibration is None:
            return None
        from tactile.calibration.file import parse_calibration  # SciPy's splines are slow to import

        return parse_calibration(self.calibration, "calibration")

    def text(self) -> str:
        """Return all as JSON."""
        return json.dumps(asdict(self))


def event_line(event: Event) -> dict[str, Any]:
    """Return an event as plain data: all that follows from the bytes, so not how long it took."""
    load = event.load
    where = None
    if load is not None and math.isfinite(load.F):
        where = {name: _finite(getattr(load, name)) for name in ("x", "y", "Q", "R", "F")}
    return {
        "type": "event", "t_s": event.t, "finger": event.finger, "sequence": event.sequence, "code": event.ternary,
        "arrows": event.code, "hand": f"{event.hand:x}", "meaning": event.meaning, "load": where,
    }  # fmt: skip


def tare_line(note: TareNote, finger: str) -> dict[str, Any]:
    """Return what became of a tare as plain data."""
    return {"type": "tare", "t_s": note.t, "finger": finger, "taken": note.offset is not None, "why": note.why}


class Watch:
    """The sink of a live run or a replay: hands lines of plain data on, and keeps what a view shows.

    ``say`` gets every event, tare and status as a dict; ``note`` gets the events and tares for a recording.
    ``now`` returns [ns] on the chunks' clock, None in a replay as fast as possible, where latency means nothing.
    """

    def __init__(
        self, source: WireSource, say: Callable[[dict[str, Any]], None], now: Callable[[], int] | None = None,
        note: Callable[[str, int, dict[str, Any]], None] | None = None, counts: Callable[[], Any] | None = None,
    ) -> None:  # fmt: skip
        self.meter = Meter()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.newest: dict[str, Report] = {}
        self.tared: dict[str, dict[str, Any]] = {}
        self.happened = 0
        self._source, self._say, self._now, self._note = source, say, now, note
        self._counts = counts or (lambda: source.counts)
        self._next = STATUS

    def __call__(self, report: Report) -> None:
        """Take one report."""
        arrival = self._source.arrival
        self.newest[report.array.name] = report
        for event in report.events:
            self.events.append(event)
            self.happened += 1
            line = event_line(event)
            self._say(line)
            if self._note is not None:
                self._note("/events", arrival, line)
        for tared in self._source.notes():
            line = tare_line(tared, self._source.arrays[tared.finger].name)
            self.tared[line["finger"]] = line
            self._say(line)
            if self._note is not None:
                offset = None if tared.offset is None else [_finite(v) for v in tared.offset.ravel().tolist()]
                self._note("/tare", arrival, line | {"offset": offset})
        now = arrival if self._now is None else self._now()
        self.meter.add((now - arrival) * 1e-9, now * 1e-9)
        if arrival >= self._next:
            self._next = arrival + STATUS
            status = self.status()
            self._say(status)
            if self._note is not None:
                self._note("/counts", arrival, status)

    def status(self) -> dict[str, Any]:
        """Return counters, rates, latencies and the clock's line as plain data."""
        now = self._source.arrival if self._now is None else self._now()
        figures = self.meter.plain(now * 1e-9)
        clock = {name: _finite(value) for name, value in self._source.clock.plain().items()}
        return {
            "type": "status", "t_s": self._source.arrival * 1e-9, "events": self.happened,
            "counts": self._counts().plain(), "clock": clock, "settled": self._source.decoder.settled(),
            **{name: _finite(value) for name, value in figures.items()},
        }  # fmt: skip

    def run(self, choices: Choices) -> None:
        """Take all frames of the source through the pipeline, and through the user's program if there is one."""
        settings = choices.settings(self._source.arrays)
        sinks: list[Callable[[Report], None]] = [self]
        if choices.program is not None:
            from tactile.cli.user_program import UserProgram  # only where it is wanted

            sinks.insert(0, UserProgram(choices.program, settings.shear, choices.backend, self._say))
        pipeline.run(self._source, settings, sinks)


def print_line(line: dict[str, Any]) -> None:
    """Print a line for other programs at once."""
    sys.stdout.write(json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n")
    sys.stdout.flush()


def paced(
    chunks: Iterable[Chunk], speed: float, now: Callable[[], float], wait: Callable[[float], None]
) -> Iterator[Chunk]:
    """Yield chunks at their times, ``speed`` times as fast."""
    start = now()
    for chunk in chunks:
        pause = start + chunk.t * 1e-9 / speed - now()
        if pause > 0:
            wait(pause)
        yield chunk


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
