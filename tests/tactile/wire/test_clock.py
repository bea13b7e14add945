"""Clock line between device and host: drift under one-sided delays, restart of the device."""

from collections.abc import Callable

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


@pytest.mark.parametrize(("clock", "what"), [
    (lambda t: 1e-3 * t, "advances 0.001 s in a second"), (lambda t: 1e3 * t, "advances 1e+03 s in a second"),
    (lambda t: 7.0, "stands still"), (lambda t: t // 1, "stands still"), (lambda t: 0.7 * t, "advances 0.7 s"),
    (lambda t: t // 0.125 * 0.125, "most frames are more than 0.02 s late"),
])  # fmt: skip
@pytest.mark.parametrize("rate", [50, 1000])
def test_a_clock_of_another_rate_gives_arrivals_and_is_reported(
    clock: Callable[[float], float], what: str, rate: int
) -> None:
    line, arrivals = ClockLine(), [n / rate for n in range(6 * rate)]
    stamps = [line(clock(t), t) for t in arrivals]
    assert what in line.trouble
    assert stamps[4 * rate :] == arrivals[4 * rate :]
    assert line.late == 0


def test_a_stall_and_a_gap_leave_the_clock_in_use() -> None:
    line, times = ClockLine(), [n * 0.01 for n in range(1000)]
    for t in times:
        late = max(t, 3.5) if 2 < t < 3.5 else t  # 1.5 s without arrivals, then all at once
        line(t + 40 * (t > 6), late + 40 * (t > 6))
    assert not line.trouble
