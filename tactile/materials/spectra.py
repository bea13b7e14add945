"""Spectra of unevenly sampled signals, power in bands, coupling of channels, and autocorrelation."""

from collections.abc import Sequence

import numpy as np

from cnnsim.support import Floats

Waves = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]
"""Complex amplitudes."""


def spectrum(at: Floats, channels: Floats, frequencies: Floats) -> Waves:
    """Return the amplitudes (channels, frequencies) of samples at any times, through a bell-shaped window.

        Y(f) = 2 sum w(k) x(k) exp(-2 pi i f t(k)) / sum w(k)

    Arguments: ``at`` (n,) [s] or [m]; ``channels`` (c, n); ``frequencies`` (m,) [1/s] or [1/m].
    """
    bell = np.hanning(len(at) + 2)[1:-1]
    turns = np.exp(-2j * np.pi * np.outer(at, frequencies))
    waves: np.ndarray[tuple[int, ...], np.dtype[np.complex128]] = 2 * (channels * bell) @ turns / bell.sum()
    return waves


def band_means(values: Floats, fine: int) -> Floats:
    """Return the means (channels, bands) over ``fine`` frequencies each."""
    means: Floats = values.reshape(len(values), -1, fine).mean(axis=2)
    return means


def coupling(waves: Waves, pairs: Sequence[tuple[int, int]], fine: int) -> Floats:
    """Return the coherence of all pairs of channels in bands: real parts, then imaginary parts.

    Each is the cross power over the root of both powers, between -1 and 1.
    """
    power = band_means(np.abs(waves) ** 2, fine) + 1e-6
    out = []
    for a, b in pairs:
        cross = (waves[a] * waves[b].conj()).reshape(-1, fine).mean(axis=1) / np.sqrt(power[a] * power[b])
        out.append(cross.reshape(-1, 2).mean(axis=1))
    both = np.concatenate(out)
    return np.concatenate([both.real, both.imag])


def memory(one: Floats, other: Floats, lags: Floats) -> Floats:
    """Return the correlation of two evenly sampled channels of mean square 1 at lags in samples, linearly interpolated.

    c(k) = sum one(n + k) other(n) / N
    """
    count = len(one)
    whole = np.correlate(one, other, "full") / count
    return np.interp(lags, np.arange(1 - count, count), whole)
