"""Noise of every taxel, from frames in which nothing happens: how large, how slow, and whose readings to leave out."""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from cnnsim.support import Flags, Floats

NORMAL_MAD = 0.6745
"""Median absolute deviation of a normal distribution of sigma 1."""
NOISY = 6.0
"""A taxel this many times as noisy as the median one of its array, in any component, is left out ..."""
FEW = 4
"""... where there are at least so many to compare with."""
FADE = 0.95
"""Part of the noise known before that is kept with each block."""
UNLIKE = 2.0
"""From so many times the median taxel's noise a taxel has one of its own."""
STRIKING = 6.0
"""Sigma from which a reading is no noise: one of 768 is as large by chance in one frame of a million."""
MANY = 64
"""Taxels from which on two frames tell the noise: to a tenth."""
BLOCKS = 20
"""The median taxel's noise is the mean over so many blocks."""


@dataclass(frozen=True)
class Noise:
    """Noise of an array: ``sigma`` (rows, cols, 3) in all, ``jitter`` (rows, cols, 3) from one frame to the next.

    ``dead`` (rows, cols): taxels that read the same to the last bit while most others do not. ``typical`` (3,): sigma
    of the median taxel, the mean over ``blocks`` blocks of frames.
    """

    sigma: Floats
    jitter: Floats
    dead: Flags
    typical: Floats
    blocks: int = 1

    @cached_property
    def noisy(self) -> Flags:
        """(rows, cols), True where a taxel has far more noise than the median one of a larger array."""
        typical = np.median(self.sigma.reshape(-1, 3), axis=0)
        enough = self.dead.size >= FEW and bool((typical > 0).all())
        return (self.sigma > NOISY * typical).any(-1) & ~self.dead & enough

    def and_before(self, before: "Noise | None") -> "Noise":
        """Return the larger of this noise and what was known before, which fades: a calm block proves little."""
        if before is None:
            return self
        sigma, jitter = np.maximum(self.sigma, FADE * before.sigma), np.maximum(self.jitter, FADE * before.jitter)
        blocks = min(before.blocks + 1, BLOCKS)
        typical = before.typical + (self.typical - before.typical) / blocks
        return Noise(sigma, jitter, self.dead, typical, blocks)

    @property
    def levels(self) -> Floats:
        """Standard deviations (rows, cols, 3) to weigh readings with: the median taxel's, but where one is noisier.

        What 20 frames say of one taxel is wrong by a fourth, and of the largest of many blocks by more.
        """
        return np.where(self.sigma > UNLIKE * self.typical, self.sigma, self.typical)

    @property
    def left_out(self) -> Flags:
        """(rows, cols), True where a taxel's reading is not to be used."""
        return self.noisy | self.dead

    @property
    def slow(self) -> Floats:
        """(rows, cols, 3), the part of the noise that is correlated from frame to frame."""
        # white noise of 20 frames has a measured sigma up to a third above its jitter
        return np.sqrt(np.maximum(self.sigma**2 - 1.7 * self.jitter**2, 0.0))

    def words(self) -> list[str]:
        """Name the taxels that are left out, and why."""
        said = [f"taxel ({i}, {j}) is noisy, left out" for i, j in np.argwhere(self.noisy & ~self.dead).tolist()]
        return said + [f"taxel ({i}, {j}) is dead, left out" for i, j in np.argwhere(self.dead).tolist()]


def measured(block: Floats) -> Noise:
    """Return the noise of frames (n, rows, cols, 3) without a load; NaN where a taxel did not read.

    Robust: median absolute deviations, about the median, and of the steps from frame to frame about theirs; frames that
    repeat the one before do not count, unless most do. No component is taken for calmer than two thirds of the array's
    median one: few frames measure a sigma badly.
    """
    differs = np.any(np.diff(block, axis=0) != 0, axis=(1, 2, 3))
    fresh = np.concatenate([block[:1], block[1:][differs]]) if 2 * differs.sum() > differs.size else block
    series = np.ascontiguousarray(np.moveaxis(fresh, 0, -1))
    sigma = _spread(series - _median(series)[..., None])
    steps = np.diff(series)
    jitter = np.zeros_like(sigma)
    if len(fresh) > 2:  # about their median: what grows steadily is no noise
        jitter = _spread(steps - _median(steps)[..., None]) / np.sqrt(2)
    still = (np.nanmax(block, axis=0) == np.nanmin(block, axis=0)).all(-1)
    dead = still & (2 * still.sum() < still.size)
    alive = np.where(dead[..., None], np.nan, sigma)
    typical = np.nan_to_num(_median(alive.reshape(-1, 3).T))
    calm = _median(jitter.reshape(-1, 3).T) * 2 / 3
    return Noise(np.maximum(sigma, typical * 2 / 3), np.maximum(jitter, calm), dead, typical)


def early_noise(before: Floats, now: Floats) -> Floats | None:
    """Return sigma (rows, cols, 3) of two frames that follow one another, the same for all taxels; None of few taxels.

    It is the robust deviation over the taxels of how far the frames differ: what presses on some of them is left out,
    and so are offsets. A component in which most taxels repeat themselves has none.
    """
    if before[..., 0].size < MANY:
        return None
    steps = np.ascontiguousarray((now - before).reshape(-1, 3).T)
    return np.broadcast_to(_spread(steps - _median(steps)[:, None]) / np.sqrt(2), before.shape)


def spread(block: Floats) -> Floats:
    """Return the robust standard deviation over the frames (n, ...), about their median; 0 where nothing was read."""
    series = np.ascontiguousarray(np.moveaxis(block, 0, -1))
    return _spread(series - _median(series)[..., None])


def _spread(series: Floats) -> Floats:
    spread: Floats = np.nan_to_num(_median(np.abs(series, out=series))) / NORMAL_MAD
    return spread


def _median(series: Floats) -> Floats:
    """Return the median along the last axis, of the readings that there are.

    Of whole series it is taken by one partition: a fifth of the time of NumPy's median, for which the frames that
    arrive meanwhile would have to wait.
    """
    if not np.isfinite(series).all():
        found: Floats = np.nanmedian(series, axis=-1)
        return found
    half, odd = divmod(series.shape[-1], 2)
    parted = np.partition(series, half)
    upper: Floats = parted[..., half]
    return upper if odd else (parted[..., :half].max(axis=-1) + upper) / 2


def is_noise(values: Floats, per_sigma: Floats) -> bool:
    """Return whether readings are no more than noise makes: none is striking, and all together are about its power.

    Arguments: ``values``; ``per_sigma``: 1 over the noise, 0 of what counts for nothing; both (rows, cols, 3).
    """
    z = (values * per_sigma).ravel()
    power = 1.5 * z.size + 7 * sqrt(2 * z.size)  # seven sigma beyond noise that is known to a fifth
    return float(z @ z) < power and float(np.abs(z).max()) < STRIKING
