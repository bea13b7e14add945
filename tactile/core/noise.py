"""Noise of every taxel from quiet frames: standard deviation, slow part, dead and noisy taxels."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cnnsim.support import Flags, Floats

NORMAL_MAD = 0.6745
"""Median absolute deviation of the standard normal distribution."""
NOISY = 6.0
"""Sigma over that of the median taxel, in any component, above which a taxel is left out."""
FEW = 4
"""Least number of taxels for this comparison."""
FADE = 0.95
"""Factor by which earlier noise fades with each block."""
UNLIKE = 2.0
"""Sigma over that of the median taxel, above which a taxel keeps its own value."""
MANY = 64
"""Number of taxels from which two frames give the noise to a tenth."""
ROUNDING = 1e-6
"""Change of a reading relative to its size that is rounding."""
LOW = 1.2
"""Relative error of the median of n robust deviations of n frames each, times n: it is low by 6 % for 20 frames."""
BLOCKS = 20
"""Number of blocks over which the noise of the median taxel is averaged."""


@dataclass(frozen=True)
class Noise:
    """Noise of an array: ``sigma`` (rows, cols, 3) in total, ``jitter`` (rows, cols, 3) from one frame to the next.

    ``dead`` (rows, cols): taxels whose readings are identical while most others vary. ``typical`` (3,): sigma of the
    median taxel, averaged over ``blocks`` blocks of frames.
    """

    sigma: Floats
    jitter: Floats
    dead: Flags
    typical: Floats
    blocks: int = 1

    @cached_property
    def noisy(self) -> Flags:
        """(rows, cols), True where a taxel of a larger array has far more noise than the median one."""
        typical = np.median(self.sigma.reshape(-1, 3), axis=0)
        measured_axes = self.sigma.any(axis=(0, 1))  # an array may measure the normal alone
        enough = self.dead.size >= FEW and bool((typical > 0)[measured_axes].all()) and bool(measured_axes.any())
        return (self.sigma > NOISY * typical).any(-1) & ~self.dead & enough

    def and_before(self, before: "Noise | None") -> "Noise":
        """Return the larger of this noise and the fading noise ``before``: a single calm block may underestimate it."""
        if before is None:
            return self
        sigma, jitter = np.maximum(self.sigma, FADE * before.sigma), np.maximum(self.jitter, FADE * before.jitter)
        blocks = min(before.blocks + 1, BLOCKS)
        typical = before.typical + (self.typical - before.typical) / blocks
        return Noise(sigma, jitter, self.dead, typical, blocks)

    def at_least(self, floor: Floats) -> "Noise":
        """Return the noise with a sigma of at least ``floor`` (rows, cols, 3)."""
        if (self.sigma >= floor).all():
            return self
        typical = np.maximum(self.typical, np.median(floor.reshape(-1, 3), axis=0))
        return replace(self, sigma=np.maximum(self.sigma, floor), typical=typical)

    @property
    def levels(self) -> Floats:
        """Standard deviations (rows, cols, 3) for weights: that of the median taxel, or its own for a noisier taxel.

        An estimate from 20 frames of a single taxel is off by a quarter.
        """
        return np.where(self.sigma > UNLIKE * self.typical, self.sigma, self.typical)

    @property
    def left_out(self) -> Flags:
        """(rows, cols), True where the readings of a taxel must not be used."""
        return self.noisy | self.dead

    @property
    def slow(self) -> Floats:
        """(rows, cols, 3), the part of the noise that is correlated between frames."""
        # white noise of 20 frames has a measured sigma up to a third above its jitter
        return np.sqrt(np.maximum(self.sigma**2 - 1.7 * self.jitter**2, 0.0))

    def words(self) -> list[str]:
        """Return one line per taxel that is left out, with the reason."""
        said = [f"taxel ({i}, {j}) is noisy, left out" for i, j in np.argwhere(self.noisy & ~self.dead).tolist()]
        return said + [f"taxel ({i}, {j}) is dead, left out" for i, j in np.argwhere(self.dead).tolist()]


def measured(block: Floats) -> Noise:
    """Return the noise of unloaded frames (n, rows, cols, 3); invalid readings are NaN.

    Robust: median absolute deviations about the median, and of the frame-to-frame steps about theirs. Repeated frames
    do not count, unless most frames repeat. No component is below two thirds of the array's median, because few frames
    give a poor estimate.
    """
    differs = (block[1:] != block[:-1]).reshape(len(block) - 1, -1).any(-1)
    many = 2 * differs.sum() > differs.size and not differs.all()
    fresh = np.concatenate([block[:1], block[1:][differs]]) if many else block
    sigma = spread(fresh)
    jitter = np.zeros_like(sigma)
    if len(fresh) > 2:  # about their median, so that a steady growth is no noise
        jitter = spread(fresh, steps=True) / np.sqrt(2)
    still = (np.fmax.reduce(block) == np.fmin.reduce(block)).all(-1)
    dead = still & (2 * still.sum() < still.size)
    alive = np.where(dead[..., None], np.nan, sigma)
    typical = np.nan_to_num(median(alive.reshape(-1, 3).T))
    calm = median(jitter.reshape(-1, 3).T) * 2 / 3
    fair = typical * (1 + LOW / len(fresh))
    return Noise(np.maximum(sigma, typical * 2 / 3), np.maximum(jitter, calm), dead, fair)


class Steps:
    """Converter steps q of every reading; noise of steps is at least q / sqrt(12).

    q is the smallest change up and down within a still block: a drift without noise has one sign. A reading that has
    not changed yet has the median of the others. Source: W. R. Bennett, "Spectra of quantized signals", Bell System
    Technical Journal 27 (1948) 446.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self._least = np.full((*shape, 3), np.inf)

    def see(self, block: Floats) -> None:
        """Process frames (n, rows, cols, 3); NaN where a taxel did not read."""
        from tactile.core.noise_numba import least_changes  # numba is slow to import

        least_changes(block.reshape(len(block), -1), ROUNDING, self._least.reshape(-1))

    @property
    def floor(self) -> Floats:
        """Least noise (rows, cols, 3); 0 where no step is known."""
        known = np.isfinite(self._least)
        if not known.any():
            return np.zeros_like(self._least)
        floor: Floats = np.where(known, self._least, np.median(self._least[known])) / np.sqrt(12)
        return floor


def early_noise(before: Floats, now: Floats) -> Floats | None:
    """Return sigma (rows, cols, 3) from two consecutive frames, equal for all taxels; None for few taxels.

    It is the robust deviation of the frame difference over the taxels, which ignores offsets and the pressed taxels. A
    component in which most taxels repeat their reading has sigma 0.
    """
    if before[..., 0].size < MANY:
        return None
    steps = np.ascontiguousarray((now - before).reshape(-1, 3).T)
    return np.broadcast_to(_spread(steps - median(steps)[:, None]) / np.sqrt(2), before.shape)


def spread(block: Floats, *, steps: bool = False) -> Floats:
    """Return the robust standard deviation over frames (n, ...) about their median, 0 without readings.

    ``steps``: that of the changes from frame to frame.
    """
    from tactile.core.noise_numba import deviations  # numba is slow to import

    series = np.moveaxis(block, 0, -1)
    series = np.diff(series) if steps else np.array(series, np.float64, order="C")
    series.sort()
    found = np.empty(series.shape[:-1])
    deviations(series.reshape(-1, series.shape[-1]), found.reshape(-1))
    return found / NORMAL_MAD


def _spread(series: Floats) -> Floats:
    spread: Floats = np.nan_to_num(median(np.abs(series, out=series))) / NORMAL_MAD
    return spread


def median(series: Floats) -> Floats:
    """Return the median along the last axis, ignoring NaN.

    One partition takes a fifth of the time of `numpy.median`, while live frames wait.
    """
    if not np.isfinite(series).all():
        found: Floats = np.nanmedian(series, axis=-1)
        return found
    half, odd = divmod(series.shape[-1], 2)
    parted = np.partition(series, half)
    upper: Floats = parted[..., half]
    return upper if odd else (parted[..., :half].max(axis=-1) + upper) / 2
