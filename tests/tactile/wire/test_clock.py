"""Clock line between device and host: drift under one-sided delays, restart of the device."""

import numpy as np
import pytest

from tactile.wire.clock import ENOUGH, LATE, ClockLine


def clocked(n: int, drift: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Device time, true host time and arrival, with delays of about 1 ms and sometimes 50 ms [s]."""
    true = np.arange(n) * 0.001
    delay = rng.exponential(1e-3, n) + (rng.random(n) < 0.02) * 0.05
    return 500 + true * (1 + drift), true, true + delay


@pytest.mark.parametrize("drift", [0.0, 80e-6, -300e-6])
def test_the_clock_line_finds_drift_under_one_sided_delays(drift: float) -> None:
    device_time, true, arrival = clocked(20_000, drift, np.random.default_rng(2))
    line = ClockLine()
    mapped = np.array([line(a, b) for a, b in zip(device_time.tolist(), arrival.tolist(), strict=True)])
    assert (np.diff(mapped) >= 0).all()
    assert np.abs(mapped - true)[5000:].max() < 2e-4  # where arrivals are off by up to 60 ms
    figures = line.plain()
    assert figures["drift_ppm"] == pytest.approx(-drift * 1e6, abs=10)  # host over device
    assert figures["residual_median_s"] == pytest.approx(np.log(2) * 1e-3, rel=0.2)
    late = int((arrival - true > LATE)[5000:].sum())
    assert line.late == pytest.approx(late * 20 / 15, rel=0.2)


def test_the_clock_line_restarts_with_the_device() -> None:
    line = ClockLine()
    for n in range(4 * ENOUGH * 100):
        line(10 + n * 0.01, 1 + n * 0.01)
    before = line(10 + 32.0, 33.0)
    assert before == pytest.approx(33.0, abs=1e-9)
    assert line(0.001, 35.0) == pytest.approx(35.0, abs=1e-9)
    assert line(1000.0, 35.5) == pytest.approx(35.5, abs=1e-9)
    assert line(float("nan"), 36.0) == 36.0
    assert line(float("nan"), 35.0) == 36.0  # never backwards
    assert ClockLine().plain()["drift_ppm"] is None
