"""Latency of a live run by stage: drained, taken by the reader's thread, made into a frame, into events, printed.

The command line's own parts, in this process, with a clock between them; the device is a process of its own.
"""

import gc
import threading
import time
from collections.abc import Iterator
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support.terminal import json_line
from tactile import pipeline
from tactile.cli.port import console
from tactile.cli.port.live import LiveMonitor, LiveOptions
from tactile.core.frame import Frame
from tactile.pipeline import FrameReport
from tactile.recording.writer import Recording
from tactile.serial.session import Session
from tactile.wire.description import Description
from tactile.wire.source import Chunk

STAGES = ("drained, recorded", "waiting in the ring", "decoded, frame recorded", "pipeline", "printed, noted")


class Clocked(Session):
    """A session that notes when its reader's thread had each chunk, and when each was taken from the ring [ns]."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        self.received: dict[int, int] = {}
        self.begun, self.reading = 0, 0.0
        super().__init__(*arguments, **more)

    def _take(self, chunks: list[Chunk]) -> None:
        now, self.reading = self.reader.now(), time.thread_time()
        self.received.update((chunk.t, now) for chunk in chunks)
        super()._take(chunks)

    def _chunks(self) -> Iterator[Chunk]:
        for chunk in super()._chunks():
            self.begun = self.now()
            yield chunk


class Stages:
    """The source of a session and the sink after its monitor: notes the time of every frame after each stage."""

    def __init__(self, session: Clocked, monitor: LiveMonitor) -> None:
        self._session, self._monitor, self._source = session, monitor, session.source
        self.arrays, self.modulus, self.title = self._source.arrays, self._source.modulus, self._source.title
        self.frames, self.tare_requests = None, self._source.tare_requests
        self.times: list[tuple[int, ...]] = []
        self._decoded = 0
        self._last = 0

    def __iter__(self) -> Iterator[Frame]:
        for frame in self._source:
            self._decoded = self._session.now()
            yield frame

    def sink(self, report: FrameReport) -> None:
        """Take the report as the live run does."""
        session, done = self._session, self._session.now()
        self._monitor(report)
        arrival = self._source.arrival
        begun = max(session.begun, self._last)  # of several frames in a chunk the later ones wait for the earlier
        got = session.received.get(arrival, arrival)
        self._last = session.now()
        self.times.append((arrival, got, max(begun, got), self._decoded, done, self._last))


class Collections:
    """How long the collector of cyclic garbage took."""

    def __init__(self) -> None:
        self.took: list[float] = []
        self._since = 0.0

    def __call__(self, phase: str, _info: dict[str, int]) -> None:
        """Hear of a collection's start or end."""
        if phase == "start":
            self._since = time.perf_counter()
        else:
            self.took.append(time.perf_counter() - self._since)


def clocked_run(port: str, description: Description, seconds: float, record: Path) -> None:
    """Run as `tactile live --json --record` does for so long, and print how long frames spend in each stage."""
    options, out = LiveOptions(tare="auto"), StringIO()

    def say(line: dict[str, Any]) -> None:
        out.write(json_line(line))

    fingers = console.warm_up(description, options)
    console.be_steady()
    collections = Collections()
    gc.callbacks.append(collections)
    into = partial(Recording, record, description, {"port": port, "choices": options.text()})
    session = Clocked(port, description, into, seconds, False, threading.Event())
    monitor = LiveMonitor(session.source, say, session.now, session.note)
    stages = Stages(session, monitor)
    spent, all_spent = time.thread_time(), time.process_time()
    try:
        pipeline.run(stages, options.settings(session.source), [stages.sink], fingers)
        spent, all_spent = time.thread_time() - spent, time.process_time() - all_spent
    finally:
        gc.callbacks.remove(collections)
        session.close()
        assert session.recording is not None
        session.recording.close({})
    each = {"pipeline's": spent, "reader's": session.reading, "all": all_spent}
    shares = ", ".join(f"{name} {1e6 * share / len(stages.times):.0f}" for name, share in each.items())
    print(f"{len(stages.times)} frames; processor a frame [us] by thread: {shares}; {session.counts}")
    _print(np.array(stages.times) * 1e-6, collections.took)


def _print(times: Any, collections: list[float]) -> None:
    print(f"{'[ms]':32}{'median':>9}{'99 %':>9}{'99.9 %':>9}{'longest':>9}")
    parts = dict(zip(STAGES, np.diff(times).T, strict=True)) | {"all": times[:, -1] - times[:, 0]}
    for name, part in parts.items():
        figures = "".join(f"{figure:9.3f}" for figure in [*np.percentile(part, [50, 99, 99.9]), part.max()])
        print(f"{name:32}{figures}")
    late = parts["all"] > np.percentile(parts["all"], 99)
    shares = " ".join(f"{name} {parts[name][late].mean():.2f}" for name in STAGES)
    when = times[late, 0] - times[0, 0]
    print(f"of the latest 1 % [ms]: {shares}; arrived {when.min():.0f} to {when.max():.0f} ms after the first")
    print(f"garbage collections: {len(collections)}, longest {1e3 * max(collections, default=0.0):.2f} ms")
