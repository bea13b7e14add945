"""Texture figures of every taxel over the last T frames: friction coefficient and roughness."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cnnsim.errors import InputError

Plane = NDArray[np.float64]


@dataclass(frozen=True)
class TextureFigures:
    """Figures (rows, cols) at one time: ``friction`` [1] and ``roughness`` [1], both NaN where not ``valid``."""

    friction: Plane
    roughness: Plane
    valid: NDArray[np.bool_]


class Texture:
    """Running mean of the instantaneous friction coefficient, and its spread in hundredths of the mean.

        mu(i) = sqrt(T_x(i)^2 + T_y(i)^2) / |S_n(i)|
        friction(t)  = sum of mu(i) / T                                           over i = t-T+1 .. t
        roughness(t) = 100 / friction(t) * sqrt(sum of (friction(t) - mu(i))^2 / (T - 1))

    Arguments: ``window`` T, at least 2; ``floor``: samples whose |S_n| is at or below it do not count (unit of the
    frames). Figures are valid once all T samples of the window count. Where nothing but zero shear was seen the
    roughness is 0.

    A frame costs O(1): the window is the tail of one block of T frames and the head of the next; the tails are
    summed up once a block, the head as it grows, and the two are joined by their means (Chan, Golub, LeVeque
    1979). Nothing is ever subtracted from a sum, so a burst leaves no rounding behind when it leaves the window.

    Raises:
        InputError: a window below 2, a floor that is negative or not finite.

    Source: Vasarhelyi, Fodor, Roska, eqs (19), (20), with the sums over exactly T samples divided by T and T - 1.
    """

    def __init__(self, window: int, floor: float) -> None:
        if window < 2:
            raise InputError(f"texture window of {window} frames, at least 2 wanted")
        if not (np.isfinite(floor) and floor >= 0):
            raise InputError(f"texture floor {floor}, a number from 0 up wanted")
        self.window = window
        self.floor = floor
        self._head = 0  # frames in the growing block
        self._streak: NDArray[np.int64] | None = None

    def update(self, values: Plane) -> TextureFigures:
        """Take the next frame's values (rows, cols, 3) and return the figures of the window that ends with it.

        Raises:
            InputError: a frame of another shape than those before.
        """
        if values.ndim != 3 or values.shape[2] != 3:
            raise InputError(f"texture frame of shape {values.shape}, (rows, cols, 3) wanted")
        shape = values.shape[:2]
        if self._streak is None:
            self._streak = np.zeros(shape, np.int64)
            self._block = np.zeros((self.window, *shape))
            # mean and sum of squares about it, of the last block's samples from k on, and of the head
            self._tails = np.zeros((self.window + 1, 2, *shape))
            self._grown = np.zeros((2, *shape))
        if shape != self._streak.shape:
            raise InputError(f"texture frame of {shape} taxels after frames of {self._streak.shape}")

        with np.errstate(all="ignore"):
            normal = np.abs(values[..., 2])
            mu = np.hypot(values[..., 0], values[..., 1]) / normal
            counts = (normal > self.floor) & np.isfinite(normal) & np.isfinite(mu)
        self._streak = np.where(counts, self._streak + 1, 0)
        mu = np.where(counts, mu, 0.0)

        self._block[self._head] = mu
        _add(self._grown, self._head, mu)
        self._head += 1
        mean, squares = _join(self._tails[self._head], self.window - self._head, self._grown, self._head)
        if self._head == self.window:
            self._start_block()

        valid = self._streak >= self.window
        spread = 100 * np.sqrt(squares / (self.window - 1))
        roughness = np.divide(spread, mean, out=np.zeros(shape), where=mean > 0)
        return TextureFigures(np.where(valid, mean, np.nan), np.where(valid, roughness, np.nan), valid)

    def _start_block(self) -> None:
        """Sum up the full block from its end; the head starts anew."""
        tail = np.zeros_like(self._grown)
        for k in range(self.window - 1, -1, -1):
            _add(tail, self.window - 1 - k, self._block[k])
            self._tails[k] = tail
        self._grown[...] = 0
        self._head = 0


def _add(moments: Plane, count: int, sample: Plane) -> None:
    """Add one sample to the (mean, squares) of ``count`` samples, in place (Welford)."""
    step = sample - moments[0]
    moments[0] += step / (count + 1)
    moments[1] += step * (sample - moments[0])


def _join(a: Plane, n_a: int, b: Plane, n_b: int) -> tuple[Plane, Plane]:
    """Return mean and squares of two groups together."""
    step = b[0] - a[0]
    total = n_a + n_b
    return a[0] + step * (n_b / total), a[1] + b[1] + step * step * (n_a * n_b / total)
