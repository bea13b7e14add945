"""PortLink: a serial port with its feed, tare and recordings, for the pages of the live array view."""

import threading
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnnsim.support.extras import need
from tactile.cli.options import new_mcap
from tactile.cli.port import console
from tactile.cli.port.live import LiveMonitor, status_words
from tactile.live_options import LiveOptions
from tactile.studio.feed import Feed

if TYPE_CHECKING:
    from tactile.recording.writer import Recording
    from tactile.serial.session import Session
    from tactile.wire.description import Description

WARNING_SECONDS = 20.0
"""Time for which a page shows a warning about the port."""
BEHIND = "after their arrival"
"""Words of the warning of a session that falls behind."""
ANSWERS = ("on request", "by force", "refused")
"""Reasons of a tare that answer a request."""
NO_TARE = "a replay takes its tare from the first frames; begin while nothing is in contact"
"""Warning of a recording without idle frames at its start."""


class PortLink:
    """A port whose frames the ``feed`` takes; ``session`` and ``monitor`` as in `tactile live`.

    ``output``: the recording of the record button; a further one has a number in its name. ``replace``: the first one
    may replace a file.

    Raises:
        InputError: the port cannot be opened, or the options are wrong.
    """

    def __init__(
        self, port: str, description: "Description", options: LiveOptions, output: Path | None = None,
        replace: bool = False,
    ) -> None:  # fmt: skip
        session_of = need("tactile.serial.session", "a serial port").Session
        self._recording_of: type[Recording] = need("tactile.recording.writer", "an MCAP recording").Recording
        if output is not None:
            new_mcap(output, replace)
        self._output, self._replace, self._description = output, replace and output is not None, description
        self._origin = {"port": port, "choices": options.text()}
        self._warned, self._warning = float("-inf"), ""
        self._asked, self._answers = set[str](), list[str]()
        fingers = console.warm_up(description, options)
        console.be_steady()
        self.session: Session = session_of(port, description, None, None, False, threading.Event(), self._warn)
        source, session = self.session.source, self.session
        self.monitor = LiveMonitor(source, self._listen, session.now, session.note, lambda: session.counts)
        settings = options.settings(source, options.skin)
        self.feed = Feed(source, settings, live=True, fingers=fingers, sinks=[self.monitor])
        self._before: dict[str, Any] = {}
        self._path = Path()

    def _warn(self, text: str) -> None:
        if BEHIND in text and time.monotonic() - self.feed.computed < WARNING_SECONDS:
            text += "; the page computed events with other thresholds meanwhile"
        self._warned, self._warning = time.monotonic(), text

    def _listen(self, line: dict[str, Any]) -> None:
        """Keep each finger's answer to a tare request."""
        if line["type"] == "tare" and line["finger"] in self._asked and line["why"].startswith(ANSWERS):
            self._asked.remove(line["finger"])
            self._answers.append(f"{line['finger']}: {console.tare_words(line)}")

    def status(self) -> dict[str, Any]:
        """Return rate, losses, state of the port, recording, tares and warning as text.

        ``lost``: why the port is closed; ``answer``: the answers to the last tare request.
        """
        session, recording = self.session, self.session.recording
        rate, losses = status_words(self.monitor.status())
        tares = "; ".join(f"{name}: {console.tare_words(line)}" for name, line in tuple(self.monitor.tared.items()))
        warned = time.monotonic() - self._warned < WARNING_SECONDS
        if recording is not None and recording.failed:
            self._warn(recording.ended)
        return {
            "rate": rate, "losses": losses, "state": session.reader.why or session.check.trouble or "open",
            "recording": "" if recording is None else self._path.name, "tare": tares,
            "warning": self._warning if warned else "", "lost": session.reader.why,
            "answer": "; ".join(self._answers),
        }  # fmt: skip

    def tare(self, force: bool) -> None:
        """Put a tare request into the stream."""
        self._answers, self._asked = [], {array.name for array in self.feed.arrays}
        self.session.reader.ask_tare(force)

    def record(self, on: bool) -> str:
        """Begin a recording, or end and close it; return a text about it, with a warning if a replay has a wrong tare.

        Raises:
            InputError: the recording cannot be made.
        """
        session = self.session
        if on and session.recording is None:
            self._path, self._before = self._next_name(), session.counts.plain()
            make = partial(self._recording_of, self._path, self._description, self._origin, replace=self._replace)
            session.begin_recording(make)
            self._replace = False
            why = self.feed.no_idle_start
            return f"{why}: {NO_TARE}; recording {self._path}" if why else f"recording {self._path}"
        recording = None if on else session.end_recording()
        if recording is None:
            return "nothing to change"
        summary = session.summary()
        summary["counts"] = {name: count - self._before.get(name, 0) for name, count in summary["counts"].items()}
        recording.close(summary)
        return recording.ended or f"recorded {self._path}"

    def _next_name(self) -> Path:
        if self._replace and self._output is not None:
            return self._output
        first = self._output or Path(time.strftime("studio-%Y%m%d-%H%M%S.mcap"))
        names = (first, *(first.with_stem(f"{first.stem}-{n}") for n in range(2, 10**4)))
        return next(one for one in names if not one.exists())

    def close(self) -> str:
        """Close the port and the recording; return a text about the frames and the recording."""
        self.session.stop()
        self.feed.stop()
        self.session.close()
        said = self.record(False)
        return f"{self.session.counts}" + (f"; {said}" if said.startswith("record") else "")
