"""Missing frames estimated from the device's rate, in formats without sequence numbers."""

import numpy as np
import pytest

from tactile.wire.rate import RateGaps
from tactile.wire.source import UNPLUGGED, Chunk, WireSource
from tests.kits.serial import sent

FRAMES = 12_000


def counted(arrivals: np.ndarray) -> int:
    gaps = RateGaps()
    for t in arrivals.tolist():
        gaps.see(t)
    return gaps.missing


def arrivals(hz: float, scatter: float, grid: float, seed: int = 0) -> np.ndarray:
    """Arrival times [s] of frames, late by `scatter` periods on average and rounded up to `grid`."""
    late = np.random.default_rng(seed).exponential(scatter / hz, FRAMES)
    came = np.maximum.accumulate(np.arange(FRAMES) / hz + late)
    return np.ceil(came / grid) * grid if grid else came


@pytest.mark.parametrize("grid", [0.0, 1e-3])
@pytest.mark.parametrize("scatter", [0.0, 0.2])
@pytest.mark.parametrize("hz", [50.0, 400.0, 1000.0])
def test_losses_are_counted_and_delays_are_not(hz: float, scatter: float, grid: float) -> None:
    came = arrivals(hz, scatter, grid)
    assert counted(came) == 0
    lost = np.random.default_rng(1).random(FRAMES) < 0.01
    assert counted(came[~lost]) == pytest.approx(lost.sum(), rel=0.25)
    gap = np.r_[0:7000, 7050:FRAMES]
    assert counted(came[gap]) == pytest.approx(50, abs=1)
    stalled = came.copy()
    stalled[5000:5300] = np.maximum(stalled[5000:5300], stalled[5300])  # 300 frames arrive at one time
    assert counted(stalled) == 0


def test_changes_of_rate_are_no_losses() -> None:
    rng = np.random.default_rng(2)
    steps = np.r_[np.full(4000, 0.005), np.full(4000, 0.01), np.full(4000, 0.002)]
    assert counted(np.cumsum(steps)) == 0
    assert counted(np.cumsum(rng.exponential(0.005, FRAMES))) == 0
    slow_drift = 0.005 * (1 + 1e-3 * np.sin(np.arange(FRAMES) / 3000))
    assert counted(np.cumsum(slow_drift)) == 0


@pytest.mark.parametrize("protocol", ["reskin", "lowiek"])
def test_a_format_without_numbers_counts_lost_frames(protocol: str) -> None:
    description, stream = sent(protocol, 4.0)
    lost = set(range(300, 307)) | {500, 620}
    chunks = [Chunk(round(t * 1e9), data) for n, (t, data) in enumerate(stream) if n not in lost]
    source = WireSource(description, chunks)
    frames = sum(1 for _ in source)
    assert source.counts.good == frames // len(description.boards) == len(stream) - len(lost)
    assert source.counts.missing_by_rate == len(lost)
    assert source.counts.missing == 0
    away = [*chunks[:400], Chunk(chunks[399].t + 1, note=UNPLUGGED), *chunks[600:]]
    pulled = WireSource(description, away)
    assert sum(1 for _ in pulled) > 0
    assert pulled.counts.missing_by_rate <= len(lost)  # frames sent while unplugged are not counted
