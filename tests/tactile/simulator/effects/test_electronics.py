"""Effects of the electronics: their declared statistics."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.simulator.effects.crosstalk import Crosstalk
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.frame_timing import FrameTiming
from tactile.simulator.effects.motor_noise import MotorNoise
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tests.kits.touch.effects import FULL, batches, scene, through


def zeros(frames: int, rows: int = 1, cols: int = 1) -> NDArray[np.float64]:
    return np.zeros((frames, rows, cols, 3))


def test_crosstalk_mixes_channels_and_neighbours() -> None:
    values = zeros(1, 3, 3)
    values[0, 1, 1] = (1.0, 0.0, 2.0)
    out = through(Crosstalk(0.1, 0.0), values)
    assert out[0, 1, 1] == pytest.approx((1.2, 0.3, 2.1))
    assert np.count_nonzero(out.any(axis=-1)) == 1
    out = through(Crosstalk(0.0, 0.1), values)
    plane = out[0, :, :, 2] / 2
    assert plane.tolist() == [[0, 0.1, 0], [0.1, 1, 0.1], [0, 0.1, 0]]


def test_motor_noise_has_its_power_tone_and_bursts() -> None:
    effect, t = MotorNoise(0.02, 130.0, 0.3, 0.05), np.arange(400_000) * 1e-3
    out = through(effect, zeros(len(t)), t)[:, 0, 0, 0] / FULL
    assert abs(out.mean()) < 2e-4
    assert (out**2).mean() == pytest.approx(0.02**2 * 0.3 / 2, rel=0.05)
    on = np.abs(np.convolve(out**2, np.ones(9), "same")) > 0
    assert on.mean() == pytest.approx(0.3 + 8e-3 / (0.05 / 0.3), rel=0.1)
    power = np.abs(np.fft.rfft(out)) ** 2
    assert np.fft.rfftfreq(len(t), 1e-3)[power.argmax()] == pytest.approx(130.0, abs=1.0)
    always = through(MotorNoise(0.02, 130.0, 1.0, 0.05), zeros(1000), t[:1000])[:, 0, 0]
    assert (always**2).mean() == pytest.approx((0.02 * FULL) ** 2 / 2, rel=0.01)
    assert np.array_equal(always[:, 0], always[:, 2])


def test_drift_has_its_variance_at_any_interval() -> None:
    effect = Drift(0.01, 0.02)
    for steps in (4, 64):
        t = np.linspace(0, 4.0, steps + 1)
        out = through(effect, zeros(steps + 1, 60, 60), t) / FULL
        assert not out[0].any()
        for k in (steps // 4, steps):
            wanted = 0.01**2 * t[k] ** 2 + 0.02**2 * t[k]
            assert out[k].var() == pytest.approx(wanted, rel=0.05)
            assert abs(out[k].mean()) < 4 * np.sqrt(wanted / 10_800)


def test_read_noise_is_white_and_normal() -> None:
    out = through(ReadNoise(0.01), zeros(40_000, 2, 2)) / (0.01 * FULL)
    flat = np.sort(out.ravel())
    from math import erf

    normal = 0.5 * (1 + np.vectorize(erf)(flat[::97] / np.sqrt(2)))
    share = (np.arange(len(flat)) + 0.5)[::97] / len(flat)
    assert np.abs(normal - share).max() < 2 / np.sqrt(len(flat))  # Kolmogorov's test at 1e-3
    assert out.var() == pytest.approx(1, abs=0.01)
    assert (out**4).mean() == pytest.approx(3, abs=0.05)
    for lag in (1, 2, 12, 24):
        a = out.ravel()
        assert abs((a[lag:] * a[:-lag]).mean()) < 4.5 / np.sqrt(len(a))
        assert abs(((a[lag:] ** 2 - 1) * (a[:-lag] ** 2 - 1)).mean()) < 9 / np.sqrt(len(a))
    other = through(ReadNoise(0.01), zeros(40_000, 2, 2), seed=2) / (0.01 * FULL)
    assert abs((out * other).mean()) < 4.5 / np.sqrt(out.size)


def test_dead_and_stuck_taxels_are_as_many_as_declared_and_stay_so() -> None:
    values = np.ones((5, 100, 100, 3))
    out = through(DeadTaxels(0.1, 0.2), values)
    assert np.array_equal(out[0], out[4])
    dead, alive = (out[0] == 0).all(axis=-1), (out[0] == 1).all(axis=-1)
    assert dead.mean() == pytest.approx(0.1, abs=0.015)
    assert (~dead & ~alive).mean() == pytest.approx(0.2, abs=0.02)
    stuck = out[0][~dead & ~alive]
    assert np.abs(stuck).max() <= FULL
    assert stuck.std() == pytest.approx(FULL / np.sqrt(3), rel=0.05)


def test_quantisation_steps_and_saturates() -> None:
    step = 2 * 1.5 * FULL / 2**8
    values = np.linspace(-0.5, 0.5, 30_000).reshape(-1, 1, 1, 3)
    out = through(Quantisation(8, 1.5), values)
    assert np.unique(np.rint(out / step)).size == 256
    assert out.min() == pytest.approx(-128 * step)
    assert out.max() == pytest.approx(127 * step)
    inside = np.abs(values) < 127 * step
    error = (out - values)[inside]
    assert np.abs(error).max() <= step / 2 * (1 + 1e-9)
    assert (error**2).mean() == pytest.approx(step**2 / 12, rel=0.01)


def test_frame_timing() -> None:
    count = 50_000
    values = np.arange(count, dtype=float).repeat(3).reshape(-1, 1, 1, 3)
    t = np.arange(count) * 0.01
    pieces = list(FrameTiming(1e-3, 0.05, 0.02)(batches(values, t, 1000), np.random.default_rng(1)))
    time, sequence, got = (
        np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("t", "sequence", "values")
    )
    assert len(time) == pytest.approx(count * 0.98, rel=0.005)
    assert (np.diff(time) >= 0).all()
    assert np.array_equal(got[:, 0, 0, 0], sequence)  # a repeated frame is the old one altogether
    fresh = np.diff(sequence, prepend=-1) > 0
    assert 1 - fresh.mean() == pytest.approx(0.05 * 0.98, rel=0.1)
    late = (time - t[sequence])[fresh]
    late = late[np.abs(late) < 5e-3]  # a repeat whose original was lost is a frame late
    assert late.std() == pytest.approx(1e-3, rel=0.03)
    assert scene(effects=(("frame_timing", FrameTiming()),)).frames is None
    assert scene(effects=(("frame_timing", FrameTiming(drops=0.0)),)).frames == 100
