"""Breaks of a stream: gaps in time, a zero that moves, a start under load, converter steps, the normal alone."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from tactile.calibration.tare_check import TareNote
from tactile.core.frame import Frame, TaxelArray
from tactile.core.gaps import Gaps
from tactile.core.source import FrameStream, Provenance
from tactile.events.event import Event, EventLog
from tactile.pipeline import run
from tactile.settings import Settings
from tests.kits.touch.made import force_stream

RNG = np.random.default_rng(5)


def pad(t: np.ndarray, rows: int = 2, cols: int = 2) -> np.ndarray:
    """Return idle readings (n, rows, cols, 3) [N]."""
    return RNG.normal(0, [0.001, 0.001, 0.003], (t.size, rows, cols, 3))


def pressed(t: np.ndarray, values: np.ndarray, *spans: tuple[float, float]) -> np.ndarray:
    for start, stop in spans:
        values[(t >= start) & (t < stop), ..., 2] += 0.4
    return values


def found(source: Any, **settings: Any) -> tuple[list[Event], list[TareNote]]:
    log, notes = EventLog(), list[TareNote]()

    def sink(report: Any) -> None:
        log.add(report.events, report.ended)
        notes.extend(note for note in report.tares if note.notice)

    run(source, Settings(**settings), [sink])
    return log.events, notes


@pytest.mark.parametrize("pause", [0.8, 60.0])
def test_a_gap_ends_events_and_starts_a_new_tare(pause: float) -> None:
    t = np.r_[0:3:0.01, 3 + pause : 6 + pause : 0.01]
    values = pressed(t, pad(t), (2, 3), (4 + pause, 5 + pause))
    values[t > 3, ..., 2] += 1.3  # another zero
    events, notes = found(force_stream(t, values))
    ends = [(one.kind, round(one.t, 1), one.end) for one in events if one.kind in ("contact", "hold")]
    assert [(kind, start) for kind, start, _ in ends] == [
        ("contact", 2.0), ("hold", 2.3), ("contact", round(4 + pause, 1)), ("hold", round(4.3 + pause, 1)),
    ]  # fmt: skip
    assert [end for _, _, end in ends[:2]] == pytest.approx([2.99, 2.99], abs=1e-6)
    assert [note.why for note in notes] == [f"no frames from 2.990 to {3 + pause:.3f} s"]
    assert not [one for one in events if 3 <= one.t < 3.5 + pause]


def test_slow_frames_and_frames_of_one_stamp_are_no_gaps() -> None:
    for times in (np.arange(20) * 1.0, np.repeat(np.arange(10), 50), np.r_[0:1:0.01, 1.4:2:0.01], np.arange(9) * 4.0):
        gaps = Gaps()
        assert [gaps(t) for t in times.tolist()] == [None] * times.size
    gaps = Gaps()
    assert [t for t in [*np.arange(0, 1, 0.1), 3.0, 3.1] if gaps(t) is not None] == [3.0]


def test_a_zero_that_falls_is_recognised_and_taken() -> None:
    t = np.arange(0, 14, 0.01)
    values = pressed(t, pad(t, 3, 4), *((p, p + 0.8) for p in range(7, 13, 2)))
    values[t >= 5, ..., 2] -= RNG.uniform(0.3, 0.6, (3, 4))
    events, notes = found(force_stream(t, values))
    assert Counter(one.kind for one in events) == {"contact": 3, "load": 3, "hold": 3, "release": 3}
    assert min(float(one.data["force_n"]) for one in events if one.kind == "hold") > 0
    ((note),) = notes
    assert note.why == "the zero moved at 5.000 s"
    assert note.t < 5.7


def test_a_start_under_load_recovers_after_the_release() -> None:
    t = np.arange(0, 9, 0.005)
    values = pressed(t, pad(t), (0, 3), (5, 6), (7, 8))
    events, notes = found(force_stream(t, values))
    holds = [one for one in events if one.kind == "hold"]
    assert [round(one.t, 1) for one in holds] == [5.3, 7.3]
    assert all(abs(float(one.data["force_n"]) - 1.6) < 0.1 for one in holds)
    assert [note.why for note in notes] == ["the zero moved at 3.000 s"]


def test_noise_and_drift_move_no_zero() -> None:
    t = np.arange(0, 6, 0.02)
    for sigma, drift in ((0.3, 0.0), (0.002, -0.004)):
        values = sigma * RNG.standard_normal((t.size, 4, 4, 3)) + drift * t[:, None, None, None]
        _, notes = found(force_stream(t, values))
        assert not notes, (sigma, drift)


@pytest.mark.parametrize(("step", "sigma"), [(0.1, 0.02), (0.25, 0.06)])
def test_converter_steps_are_no_events(step: float, sigma: float) -> None:
    """A still hold in steps has one contact, one hold and one release, as without the steps."""
    t = np.arange(0, 12, 0.01)
    values = RNG.normal(0, sigma, (t.size, 2, 2, 3))
    grip = np.interp(t, [2, 2.3, 10, 10.2], [0, 10 * step, 10 * step, 0])
    values[..., 2] += grip[:, None, None] * np.array([[1, 0.35], [0.35, 0.15]])
    events, _ = found(force_stream(t, np.round(values / step) * step))
    kinds = Counter(one.kind for one in events)
    assert kinds.pop("load", 1) == 1
    assert kinds == {"contact": 1, "hold": 1, "release": 1}


def test_taxels_at_the_end_of_their_range_are_named() -> None:
    t = np.arange(0, 8, 0.005)
    values = pressed(t, pad(t), (2, 6))
    values[(t >= 2) & (t < 6), 0, 1, 2] *= 3
    values[..., 2] = np.minimum(values[..., 2], 0.9)  # the converter's last value
    _, notes = found(force_stream(t, values))
    assert [note.why for note in notes] == ["taxels that stand at an end of their range: (0, 1) at 0.9"]
    assert notes[0].detail == "their newtons, and the sum, are lower bounds"
    values = pressed(t, pad(t), (2, 6))
    assert not found(force_stream(t, values))[1]


def test_arrays_of_the_normal_alone_have_contacts_and_holds_and_no_slip() -> None:
    t = np.arange(0, 8, 0.01)
    values = pressed(t, pad(t, 4, 4), (2, 4), (5, 7))
    values[(t >= 5) & (t < 7), :, :, 2] *= 1 + 0.2 * RNG.standard_normal((200, 1, 1))  # an unsteady grip
    values[..., :2] = 0.0
    array = TaxelArray("pad", 4, 4, 4e-3, 0.0, quantity="force", shear=False)
    frames = [Frame(0, at, n, values[n], np.ones((4, 4), bool)) for n, at in enumerate(t.tolist())]
    friction: list[bool] = []
    log = EventLog()

    def sink(report: Any) -> None:
        log.add(report.events, report.ended)
        friction.append(bool(report.texture.valid.any()))

    run(FrameStream("n", (array,), None, len(frames), frames, Provenance(untared=True)), Settings(), [sink])
    kinds = Counter(one.kind for one in log.events)
    assert kinds["contact"] == kinds["release"] == 2
    assert kinds["hold"] >= 1
    assert not kinds.keys() & {"slip", "incipient_slip", "tangential_load", "twist", "pull", "lift"}
    assert not any(friction)
    middle = next(one.load for one in log.events if one.kind == "hold")
    assert middle is not None
    assert (round(middle.x, 4), round(middle.y, 4)) == (0.0, 0.0)
