"""Effects between a taxel and its number: their declared statistics and closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.simulator.effects.electronics.clipping import Clipping
from tactile.simulator.effects.electronics.low_pass import LowPass
from tactile.simulator.effects.electronics.multiplex_skew import MultiplexSkew
from tactile.simulator.effects.electronics.pink_noise import PinkNoise
from tactile.simulator.effects.electronics.taxel_mismatch import TaxelMismatch
from tactile.simulator.effects.electronics.temperature import Temperature
from tests.kits.touch.effects import FULL, through


def zeros(frames: int, rows: int = 1, cols: int = 1) -> NDArray[np.float64]:
    return np.zeros((frames, rows, cols, 3))


def test_mismatch_is_drawn_once_a_taxel_with_its_deviations() -> None:
    ones = np.ones((2, 80, 80, 3))
    gains = through(TaxelMismatch(0.05, 0.0, 0.0), ones)
    assert np.array_equal(gains[0], gains[1])
    assert np.array_equal(gains[..., 0], gains[..., 2])  # one gain a taxel
    assert gains[0, ..., 0].std() == pytest.approx(0.05, rel=0.05)
    ratios = through(TaxelMismatch(0.05, 0.0, 0.04), ones)
    beta = ratios[0, ..., 0] / ratios[0, ..., 2]
    assert np.allclose(ratios[..., 0], ratios[..., 1])
    assert beta.std() == pytest.approx(0.04, rel=0.05)
    zero = through(TaxelMismatch(0.05, 0.01, 0.04), zeros(1, 80, 80)) / FULL
    assert zero.std() == pytest.approx(0.01, rel=0.05)
    assert abs(np.corrcoef(zero[0, ..., 0].ravel(), zero[0, ..., 2].ravel())[0, 1]) < 0.06


def test_warming_up_changes_gain_and_zero() -> None:
    t = np.linspace(5.0, 305.0, 50)
    x = np.full((50, 1, 1, 3), 0.02)
    out = through(Temperature(2.0, 10.0, 100.0, -0.01, 0.002), x, t, cut=7)[:, 0, 0, 1]
    warm = 2.0 + 10.0 * (1 - np.exp(-(t - 5.0) / 100.0))
    assert out == pytest.approx(0.02 * (1 - 0.01 * warm) + 0.002 * FULL * warm)


def test_pink_noise_has_its_deviation_and_spectrum() -> None:
    low, rate = 0.1, 2000.0
    t = np.arange(1 << 14) / rate
    out = through(PinkNoise(0.01, low, 1000.0), zeros(len(t), 8, 8), t).reshape(len(t), -1) / FULL
    assert out.std() == pytest.approx(0.01, rel=0.02)
    hann = np.hanning(len(t))[:, None]
    power = (np.abs(np.fft.rfft(out * hann, axis=0)) ** 2).mean(axis=1) * 2 / (rate * (hann**2).sum())
    f = np.fft.rfftfreq(len(t), 1 / rate)
    for start in (2.0, 4.0, 8.0, 16.0, 32.0):  # octaves of the stated band, from 20 low to high / 20
        octave = power[(f >= start) & (f < 2 * start)]
        inner = f[(f >= start) & (f < 2 * start)]
        assert (octave * inner).mean() * np.log(1e4) / 0.01**2 == pytest.approx(1, abs=0.06)
    a, b = out[:, 0].copy(), out[:, 37].copy()
    assert abs(np.corrcoef(np.diff(a), np.diff(b))[0, 1]) < 0.05


def test_pink_noise_is_stationary_at_any_interval_and_however_it_is_cut() -> None:
    effect = PinkNoise(0.01, 0.1, 1000.0)
    late = through(effect, zeros(2, 60, 60), np.array([0.0, 1e6])) / FULL
    assert late.std(axis=(1, 2, 3)) == pytest.approx((0.01, 0.01), rel=0.05)
    t = np.cumsum(np.random.default_rng(3).exponential(1e-2, 1000))
    whole = through(effect, zeros(1000, 2, 3), t)
    for cut in (1, 7, 333):
        assert np.array_equal(whole, through(effect, zeros(1000, 2, 3), t, cut=cut))


def test_clipping_ends_at_the_rails() -> None:
    values = np.linspace(-0.3, 0.3, 300).reshape(-1, 1, 1, 3)
    assert through(Clipping(0.8), values) == pytest.approx(np.clip(values, -0.08, 0.08))


def test_low_pass_is_the_closed_form() -> None:
    t = np.cumsum(np.random.default_rng(2).exponential(2e-3, 200))
    ramp = np.repeat(t - t[0], 3).reshape(-1, 1, 1, 3)
    out = through(LowPass(5e-3), ramp, t, cut=13)[:, 0, 0, 2]
    since = t - t[0]
    assert out == pytest.approx(since - 5e-3 * (1 - np.exp(-since / 5e-3)), rel=1e-12, abs=1e-15)


def test_a_multiplexer_reads_one_channel_after_the_other() -> None:
    t = np.arange(20) * 1e-2
    ramp = np.broadcast_to(t[:, None, None, None], (20, 2, 2, 3)).copy()
    out = through(MultiplexSkew(1e-4), ramp, t, cut=6)
    late = np.arange(11, -1, -1).reshape(2, 2, 3) * 1e-4
    assert out[1:] == pytest.approx(ramp[1:] - late)
    assert np.array_equal(out[0], ramp[0])  # there was nothing before
    assert out[:, 1, 1, 2] == pytest.approx(t)
