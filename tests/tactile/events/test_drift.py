"""Drift in a contact: taken off where nothing presses, up to a limit; skin that creeps after one begins no other."""

import numpy as np
import pytest

from cnnsim.program.machine import UniversalMachine
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.events.detector_file import SHIPPED, shipped_detectors
from tactile.events.event import EventLog
from tactile.events.signals.drift_numba import FOLLOWS, follow
from tactile.pipeline import FrameReport, run
from tactile.settings import Settings

LEVEL, MOST, DT = 0.02, 0.1, 0.005


def followed(course: np.ndarray, pressing: float = 0.0, beside: float = 2.0) -> np.ndarray:
    """Shear along x of one taxel as it is left, its mean taken for what it is; what another one bears beside it."""
    fast, base, out = np.zeros((1, 2, 3)), np.zeros((1, 2, 3)), np.zeros((1, 2, 3))
    on, most, use = np.full((1, 2, 3), LEVEL), np.full(3, MOST), np.ones((1, 2), bool)
    common, fastest = np.zeros(3), np.zeros(3)  # of two taxels, one that is pressed
    left = []
    for value in course:
        values = np.array([[[value, 0.0, pressing], [0.0, 0.0, beside]]])
        follow(values, fast, use, on / 2, on, most, fastest, DT, True, common, base, out)
        fast[:] = out
        left.append(out[0, 0, 0])
    return np.array(left)


def test_what_grows_slowly_is_followed_up_to_a_limit_and_what_comes_at_once_stays() -> None:
    t = np.arange(0.0, 8.0, DT)
    slow = followed(0.02 * t)  # lags by the rate times the time constant, until the limit
    assert slow[t < 4].max() == pytest.approx(0.02 * FOLLOWS, abs=5e-4)
    assert slow[-1] == pytest.approx(0.02 * t[-1] - MOST, abs=1e-3)
    assert followed(2 * LEVEL / FOLLOWS * t)[t > 1].min() > LEVEL  # faster than a level in the time constant
    assert followed(np.where(t > 1, 1.5 * LEVEL, 0.0))[-1] == 1.5 * LEVEL
    assert np.array_equal(followed(0.02 * t, pressing=1.0), 0.02 * t)
    assert np.array_equal(followed(0.02 * t, beside=10 * LEVEL), 0.02 * t)  # light: some of it may be below the level


def test_a_held_grip_of_a_pad_that_drifts_has_one_code_a_release_and_sudden_shear_in_the_skin() -> None:
    rng, array = np.random.default_rng(8), TaxelArray("pad", 3, 3, 4e-3, 0.0, quantity="force")
    t = np.arange(0.0, 5.5, 0.004)
    values = (1.1e-3, 1.1e-3, 3.6e-3) * rng.standard_normal((len(t), 3, 3, 3))
    values += 0.02 * t[:, None, None, None] * np.array([1.0, -0.7, 1.0])
    values[:, 1, 1] += np.interp(t, [0.5, 0.6, 4.9, 5.0], [0, 1, 1, 0])[:, None] * np.array([0.3, 0.3, 3.0])
    values[:, 0, 2, 0] -= np.where((t > 3.5) & (t < 4.9), 0.06, 0.0)
    frames = [
        Frame(0, time, n, one, np.ones((3, 3), bool))
        for n, (time, one) in enumerate(zip(t.tolist(), values, strict=True))
    ]
    log, codes = EventLog(), list[str]()

    def sink(report: FrameReport) -> None:
        log.add(report.events, report.ended)
        codes.append(report.code.ternary())

    run(FrameStream("", (array,), None, len(t), frames, Provenance(untared=True)), Settings(tare="auto"), [sink])
    before, after = (set(np.array(codes)[(t > lo) & (t < hi)].tolist()) for lo, hi in ((0.8, 3.5), (3.6, 4.9)))
    assert len(before) == len(after) == 1
    assert (before.pop()[4:6], after.pop()[4:6]) == ("00", "-0")
    assert [event.t for event in log.events if event.kind == "release"] == [pytest.approx(5.0, abs=0.05)]


def test_while_silicone_creeps_two_light_taxels_begin_no_contact_but_by_a_load_that_rises() -> None:
    (file,) = (one for one in shipped_detectors(SHIPPED) if one.name == "contact")
    machine = UniversalMachine("cpu", "float64")
    black, white = np.ones((3, 3)), -np.ones((3, 3))

    def taxels(*cells: tuple[int, int]) -> np.ndarray:
        plane = white.copy()
        for cell in cells:
            plane[cell] = 1.0
        return plane

    def step(touch: np.ndarray, **planes: np.ndarray) -> tuple[bool, bool]:
        given = dict.fromkeys(file.program.inputs, white) | {"touch": touch, "loaded": black} | planes
        out = machine.run(file.program, **given)
        return bool(out["in_contact"]), bool(out["released"])

    held = taxels((1, 1), (2, 1))
    assert step(held, large=black, rising=black) == (True, False)
    assert step(held, large=black, falling=black, steep=black, unsteady=black) == (True, False)
    assert step(held, unsteady=black) == (False, True)  # the knee, above a tail
    light = taxels((1, 1), (2, 1), (0, 0), (1, 0))
    assert step(light, unsteady=black) == (False, True)
    assert step(light, rising=black) == (True, False)


def test_a_grip_on_all_taxels_that_all_drift_upwards_has_one_contact_and_a_release() -> None:
    rng, array = np.random.default_rng(9), TaxelArray("pad", 3, 3, 4e-3, 0.0, quantity="force")
    t = np.arange(0.0, 6.0, 0.004)
    values = np.array([1.1e-3, 1.1e-3, 3.6e-3]) * rng.standard_normal((len(t), 3, 3, 3))
    values[..., 2] += 0.05 * t[:, None, None]
    held = np.array([[0.1, 0.3, 0.1], [0.3, 0.9, 0.3], [0.1, 0.3, 0.1]])
    values[..., 2] += np.interp(t, [0.5, 0.6, 4.9, 5.0], [0, 1, 1, 0])[:, None, None] * held
    every = np.ones((3, 3), bool)
    frames = [Frame(0, float(t[n]), n, one, every) for n, one in enumerate(values)]
    log = EventLog()
    stream = FrameStream("", (array,), None, len(t), frames, Provenance(untared=True))
    run(stream, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    told = [event for event in log.events if event.kind in ("contact", "release")]
    assert [event.kind for event in told] == ["contact", "release"]
    assert [event.t for event in told] == [pytest.approx(0.5, abs=0.03), pytest.approx(5.0, abs=0.05)]


def slow(pattern: np.ndarray, rate: float, top: float) -> tuple[EventLog, float]:
    """Events of a press at ``rate`` [N/s] to ``top`` [N], held for 5 s, and the load [N] in the middle of the hold."""
    rng, array = np.random.default_rng(3), TaxelArray("pad", len(pattern), len(pattern), 4e-3, 0.0, quantity="force")
    t = np.arange(0.0, 1.0 + top / rate + 5.0, 0.01)
    values = np.array([1.1e-3, 1.1e-3, 3.6e-3]) * rng.standard_normal((len(t), *pattern.shape, 3))
    values[..., 2] += np.minimum(rate * np.maximum(t - 1.0, 0.0), top)[:, None, None] * pattern / pattern.sum()
    every = np.ones(pattern.shape, bool)
    frames = [Frame(0, float(t[n]), n, one, every) for n, one in enumerate(values)]
    log, loads = EventLog(), list[float]()
    stream = FrameStream("", (array,), None, len(t), frames, Provenance(untared=True))
    run(
        stream,
        Settings(tare="auto"),
        [lambda report: log.add(report.events, report.ended), lambda report: loads.append(report.load.F)],
    )
    return log, float(np.median(loads[-300:]))


@pytest.mark.parametrize("rate", [0.1, 0.3])
def test_a_touch_that_comes_slowly_is_told_and_has_its_newtons(rate: float) -> None:
    log, load = slow(np.array([[2.0, 7.0, 2.0], [5.0, 20.0, 5.0], [1.0, 6.0, 1.0]]), rate, 1.0)
    (contact,) = (event for event in log.events if event.kind == "contact")
    assert contact.end is None
    assert load == pytest.approx(1.0, abs=0.05)


def test_what_grows_alike_on_all_taxels_and_slowly_is_drift() -> None:
    log, load = slow(np.array([[0.8, 1.2], [1.1, 0.9]]), 0.06, 0.6)
    assert not log.events
    assert load == pytest.approx(0.0, abs=0.05)
