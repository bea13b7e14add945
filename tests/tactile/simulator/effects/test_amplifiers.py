"""Effects between a taxel and its number: their declared statistics and closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.simulator.effects.electronics.pink_noise import PinkNoise
from tactile.simulator.effects.electronics.taxel_mismatch import TaxelMismatch
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
