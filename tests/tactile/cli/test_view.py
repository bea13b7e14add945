"""The live view, its latency percentiles, and replay speed."""

import io

import numpy as np
import pytest
from rich.console import Console

from tactile.cli.port.live import LiveMonitor
from tactile.cli.port.meter import Meter
from tactile.cli.port.replayed import paced
from tactile.cli.port.view import LiveView
from tactile.live_options import LiveOptions
from tactile.wire.source import Chunk, WireSource
from tests.kits.serial import sent


def test_the_live_view_shows_arrows_events_and_losses() -> None:
    description, stream = sent("native", 1.2)
    source = WireSource(description, [Chunk(round(t * 1e9), data) for t, data in stream])
    watch = LiveMonitor(source, lambda line: None)
    watch.run(LiveOptions(tare="off"))
    watch.tared["left"] = {"t_s": 0.5, "why": "refused: loaded", "detail": ""}
    console = Console(file=io.StringIO(), width=110, force_terminal=True, color_system=None)
    console.print(LiveView(watch, "grip", lambda: "/dev/skin: open"))
    shown = console.file.getvalue()  # type: ignore[attr-defined]  # a StringIO
    assert "left" in shown
    assert "right" in shown
    assert any(arrow in shown for arrow in "↖↗↘↙↓")
    assert watch.events[-1].words in shown
    assert "480 good, 0 bad checksum, 0 resynchronised, 0 missing" in shown
    assert "/dev/skin: open" in shown
    assert "frames/s" in shown
    assert "tare of left at 0.500 s: refused: loaded" in shown


def test_meter_percentiles_are_within_five_percent() -> None:
    meter = Meter()
    assert np.isnan(meter.percentile(50))
    latencies = np.random.default_rng(0).lognormal(-7, 1, 5000)
    for n, latency in enumerate(latencies.tolist()):
        meter.add(latency, n * 0.002)
    for percent in (1, 50, 99):
        assert meter.percentile(percent) == pytest.approx(np.percentile(latencies, percent), rel=0.05)
    assert meter.longest == latencies.max()
    for one in (1e-9, 1.04e-3, 2e3):
        single = Meter()
        single.add(one, 0.0)
        assert single.percentile(99) <= single.longest == one
    assert meter.rate(4999 * 0.002) == pytest.approx(500, abs=2)
    assert meter.rate(100.0) == 0


def test_paced_chunks_keep_their_times() -> None:
    clock = [100.0]
    chunks = [Chunk(round(t * 1e9)) for t in (0.0, 0.5, 0.5, 2.0)]
    waits: list[float] = []

    def wait(seconds: float) -> None:
        waits.append(seconds)
        clock[0] += seconds

    assert list(paced(chunks, 2.0, lambda: clock[0], wait)) == chunks
    assert waits == pytest.approx([0.25, 0.75], abs=1e-12)
