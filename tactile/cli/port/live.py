"""The pipeline on a port or a recording of one: options, printed and recorded lines."""

from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from tactile import pipeline
from tactile.calibration.live_tare import IDLE
from tactile.calibration.tare_check import TareNote
from tactile.cli.port.meter import Meter
from tactile.cli.port.recorded_frames import RecordedFrames
from tactile.events.event import Event
from tactile.live_options import LiveOptions
from tactile.output.event_data import EventData, finite, program_data
from tactile.pipeline import FrameReport
from tactile.wire.source import WireSource

if TYPE_CHECKING:
    from tactile.finger import Finger

EVENTS_KEPT = 12
STATUS = 10**9
"""[ns] Period of the status lines."""


def tare_line(note: TareNote, finger: str) -> dict[str, Any]:
    """Return a change of the tare as plain data."""
    return {
        "type": "tare", "t_s": note.t, "finger": finger, "taken": note.offset is not None, "why": note.why,
        "detail": note.detail,
    }  # fmt: skip


def status_words(status: dict[str, Any]) -> tuple[str, str]:
    """Return the rate, latency and clock of a status, and its counters, as text."""
    lost = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in status["counts"].items())
    median, most = ((status[f"latency_{name}_s"] or 0.0) * 1e3 for name in ("median", "p99"))
    clock = status["clock"]["residual_median_s"]
    line = "" if clock is None else f"; device clock {status['clock']['drift_ppm']:+.0f} ppm, off {clock * 1e3:.2f} ms"
    return f"{status['rate_hz']:.0f} frames/s; latency {median:.2f} ms, 99 % {most:.2f} ms{line}", lost


class LiveMonitor:
    """The sink of a live run or a replay: passes lines of plain data on, and keeps the state of the view.

    ``say`` receives every event, tare and status as a dict; ``note`` receives events and tares for a recording. ``now``
    returns [ns] on the clock of the chunks, None in a fast replay, which has no latency.
    """

    def __init__(
        self, source: WireSource | RecordedFrames, say: Callable[[dict[str, Any]], None],
        now: Callable[[], int] | None = None,
        note: Callable[[str, int, dict[str, Any]], None] | None = None, counts: Callable[[], Any] | None = None,
    ) -> None:  # fmt: skip
        self.meter = Meter()
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self.newest: dict[str, FrameReport] = {}
        self.tared: dict[str, dict[str, Any]] = {}
        self.happened = 0
        self._source, self._say, self._now = source, say, now
        self._note = note or (lambda topic, t, data: None)
        self._counts = counts or (lambda: source.counts)
        self._next = STATUS
        self._plain = EventData(source.arrays)

    def __call__(self, report: FrameReport) -> None:
        """Process one report."""
        arrival = self._source.arrival
        self.newest[report.array.name] = report
        for event in report.events:
            self.events.append(event)
            self.happened += 1
            line = {"type": "event"} | self._plain(event)
            self._say(line)
            self._note("/events", arrival, line)
        for event in report.ended:
            line = {"type": "event_end"} | self._plain.end(event)
            self._say(line)
            self._note("/events", arrival, line)
        for name, outputs in report.outputs.items():
            self._say({"type": "program"} | program_data(report.frame.t, report.array.name, name, outputs))
        for tared in report.tares:
            line = tare_line(tared, self._source.arrays[tared.finger].name)
            again = line["why"] == IDLE == self.tared.get(line["finger"], line | {"why": ""})["why"]
            self.tared[line["finger"]] = line
            if not again:  # twice a second would be too much to read
                self._say(line)
            offset = None if tared.offset is None else [finite(v) for v in tared.offset.ravel().tolist()]
            self._note("/tare", arrival, line | {"offset": offset})
        now = arrival if self._now is None else self._now()
        self.meter.add((now - arrival) * 1e-9, now * 1e-9)
        if arrival >= self._next:
            self._next = arrival + STATUS
            status = self.status()
            self._say(status)
            self._note("/counts", arrival, status)

    def status(self) -> dict[str, Any]:
        """Return counters, rates, latencies and the line of the device clock as plain data."""
        now = self._source.arrival if self._now is None else self._now()
        figures = self.meter.plain(now * 1e-9)
        clock = {name: finite(value) for name, value in self._source.clock.plain().items()}
        return {
            "type": "status", "t_s": self._source.arrival * 1e-9, "events": self.happened,
            "counts": self._counts().plain(), "clock": clock, "settled": self._source.settled(),
            **{name: finite(value) for name, value in figures.items()},
        }  # fmt: skip

    def run(
        self, options: LiveOptions, fingers: "list[Finger] | None" = None, sinks: Iterable[pipeline.Sink] = ()
    ) -> None:
        """Take all frames of the source through the pipeline; ``fingers`` as `pipeline.run`.

        ``sinks`` get each report before the latency of its frame is measured.
        """
        pipeline.run(self._source, options.settings(self._source, options.skin), [*sinks, self], fingers)
