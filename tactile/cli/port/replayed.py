"""Replay: the pipeline on the bytes of a recorded port, or on the frames of any other recording."""

import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cnnsim.support.extras import need
from tactile import pipeline
from tactile.cli.port.live import LiveMonitor
from tactile.cli.port.recorded_frames import RecordedFrames
from tactile.core.source import ForeignFileError
from tactile.live_options import recorded_options
from tactile.opened import RunChoices, open_for_run
from tactile.settings import PipelineOptions
from tactile.wire.reading import Counts
from tactile.wire.source import Chunk, WireSource

if TYPE_CHECKING:
    from tactile.recording.reader import Recorded

Say = Callable[[dict[str, Any]], None]


def wire_recording(path: Path) -> "Recorded | None":
    """Open a recording that holds the bytes of a port; return None for every other file."""
    if path.is_dir() or path.suffix.lower() != ".mcap":
        return None
    try:
        recorded: Recorded = need("tactile.recording.reader", "an MCAP recording").open_recording(path)
    except ForeignFileError:
        return None
    return recorded if recorded.has_wire else None


def replay_bytes(
    recorded: "Recorded", name: str, options: PipelineOptions, speed: float | None, say: Say
) -> tuple[LiveMonitor, Counts]:
    """Run the bytes of a recording through the decoder, with the options of the live run where there are no others."""
    chosen = recorded_options(recorded.made.get("choices", "{}"), name).but(options)
    if chosen.calibration is None:
        recorded.description.check_calibrated()
    chunks: Iterable[Chunk] = recorded.chunks()
    if speed is not None:
        chunks = paced(chunks, speed, time.monotonic, time.sleep)
    source = WireSource(recorded.description, chunks)
    monitor = LiveMonitor(source, say)
    monitor.run(chosen)
    return monitor, source.counts


def replay_frames(
    path: Path, layout: Path | None, options: PipelineOptions, speed: float | None, say: Say
) -> tuple[LiveMonitor, Counts]:
    """Run the frames of a recording, with the settings of `tactile run`."""
    opened = open_for_run(path, RunChoices(options, layout=layout))
    source = RecordedFrames(opened.source, speed)
    monitor = LiveMonitor(source, say)
    pipeline.run(source, opened.settings, [monitor])
    return monitor, source.counts


def paced(
    chunks: Iterable[Chunk], speed: float, now: Callable[[], float], wait: Callable[[float], None]
) -> Iterator[Chunk]:
    """Yield chunks on time, at ``speed`` times the recorded rate."""
    start = now()
    for chunk in chunks:
        pause = start + chunk.t * 1e-9 / speed - now()
        if pause > 0:
            wait(pause)
        yield chunk
