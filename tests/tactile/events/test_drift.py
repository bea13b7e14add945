"""Drift compensation during contact: up to a limit, where no load presses, without suppressing slow loads."""

import numpy as np
import pytest

from tactile.events.event import EventLog
from tactile.pipeline import FrameReport, run
from tactile.settings import Settings
from tests.kits.touch.made import events, force_stream


def test_a_held_grip_on_a_drifting_pad_keeps_its_code() -> None:
    rng = np.random.default_rng(8)
    t = np.arange(0.0, 5.5, 0.004)
    values = (1.1e-3, 1.1e-3, 3.6e-3) * rng.standard_normal((len(t), 3, 3, 3))
    values += 0.02 * t[:, None, None, None] * np.array([1.0, -0.7, 1.0])
    values[:, 1, 1] += np.interp(t, [0.5, 0.6, 4.9, 5.0], [0, 1, 1, 0])[:, None] * np.array([0.3, 0.3, 3.0])
    values[:, 0, 2, 0] -= np.where((t > 3.5) & (t < 4.9), 0.06, 0.0)
    log, codes = EventLog(), list[str]()

    def sink(report: FrameReport) -> None:
        log.add(report.events, report.ended)
        codes.append(report.code.ternary())

    run(force_stream(t, values), Settings(tare="auto"), [sink])
    before, after = (set(np.array(codes)[(t > lo) & (t < hi)].tolist()) for lo, hi in ((0.8, 3.5), (3.6, 4.9)))
    assert len(before) == len(after) == 1
    assert (before.pop()[4:6], after.pop()[4:6]) == ("00", "-0")
    assert [event.t for event in log.events if event.kind == "release"] == [pytest.approx(5.0, abs=0.05)]


def test_a_grip_on_taxels_that_all_drift_has_one_contact_and_one_release() -> None:
    rng = np.random.default_rng(9)
    t = np.arange(0.0, 6.0, 0.004)
    values = np.array([1.1e-3, 1.1e-3, 3.6e-3]) * rng.standard_normal((len(t), 3, 3, 3))
    values[..., 2] += 0.05 * t[:, None, None]
    held = np.array([[0.1, 0.3, 0.1], [0.3, 0.9, 0.3], [0.1, 0.3, 0.1]])
    values[..., 2] += np.interp(t, [0.5, 0.6, 4.9, 5.0], [0, 1, 1, 0])[:, None, None] * held
    found = [event for event in events(force_stream(t, values), tare="auto") if event.kind in ("contact", "release")]
    assert [event.kind for event in found] == ["contact", "release"]
    assert [event.t for event in found] == [pytest.approx(0.5, abs=0.03), pytest.approx(5.0, abs=0.05)]


def slow_press(pattern: np.ndarray, rate: float, top: float) -> tuple[EventLog, float]:
    """Return the events of a press at ``rate`` [N/s] to ``top`` [N], and the median load [N] of the last 3 s."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 1.0 + top / rate + 5.0, 0.01)
    values = np.array([1.1e-3, 1.1e-3, 3.6e-3]) * rng.standard_normal((len(t), *pattern.shape, 3))
    values[..., 2] += np.minimum(rate * np.maximum(t - 1.0, 0.0), top)[:, None, None] * pattern / pattern.sum()
    log, loads = EventLog(), list[float]()
    run(
        force_stream(t, values),
        Settings(tare="auto"),
        [lambda report: log.add(report.events, report.ended), lambda report: loads.append(report.load.F)],
    )
    return log, float(np.median(loads[-300:]))


@pytest.mark.parametrize("rate", [0.1, 0.3])
def test_a_slow_press_is_a_contact_with_its_force(rate: float) -> None:
    log, load = slow_press(np.array([[2.0, 7.0, 2.0], [5.0, 20.0, 5.0], [1.0, 6.0, 1.0]]), rate, 1.0)
    (contact,) = (event for event in log.events if event.kind == "contact")
    assert contact.end is None
    assert load == pytest.approx(1.0, abs=0.05)


def test_slow_growth_alike_on_all_taxels_is_drift() -> None:
    log, load = slow_press(np.array([[0.8, 1.2], [1.1, 0.9]]), 0.06, 0.6)
    assert not log.events
    assert load == pytest.approx(0.0, abs=0.05)
