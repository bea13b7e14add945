"""Texture figures of every taxel over the last T frames: friction coefficient and roughness, eqs (19), (20)."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Flags, Floats, InputError, Integers
from cnnsim.support.limits import WINDOW, check_most


@dataclass(frozen=True)
class TextureFigures:
    """Texture figures (rows, cols) at one time: ``friction`` and ``roughness`` [1], both NaN where not ``valid``."""

    friction: Floats
    roughness: Floats
    valid: Flags


class Texture:
    """Moving average of the instantaneous friction coefficient, and its spread in percent of the mean.

        mu(i) = sqrt(T_x(i)^2 + T_y(i)^2) / |S_n(i)|
        friction(t)  = sum of mu(i) / T                                           over i = t-T+1 .. t
        roughness(t) = 100 / friction(t) * sqrt(sum of (friction(t) - mu(i))^2 / (T - 1))

    Arguments: ``window`` T, at least 2; ``floor``: samples with |S_n| at or below it are excluded (unit of the frames).
    Figures are valid once T consecutive samples count. Zero shear gives roughness 0.

    A frame costs O(1): the window is the tail of one block of T frames and the head of the next. The tails are summed
    once per block, the head as it grows, and both are joined by their means (Chan, Golub, LeVeque 1979). No sum is ever
    reduced by subtraction, so a burst leaves no rounding error when it leaves the window.

    Raises:
        InputError: a window below 2, a floor that is negative or not finite.

    Source: Vasarhelyi, Fodor, Roska, eqs (19), (20), with the sums over exactly T samples divided by T and T - 1.
    """

    def __init__(self, window: int, floor: float) -> None:
        check_most(window, WINDOW, "texture window in frames")
        if window < 2:
            raise InputError(f"texture window of {window} frames, at least 2 wanted")
        if not (np.isfinite(floor) and floor >= 0):
            raise InputError(f"texture floor {floor}, a number from 0 up wanted")
        from tactile.texture.figures_numba import step  # numba is slow to import

        self._step = step
        self.window = window
        self.floor = floor
        self._head = 0  # frames in the growing block
        self._streak: Integers | None = None

    def update(self, values: Floats) -> TextureFigures:
        """Process a frame (rows, cols, 3) and return the figures of the window that ends with it.

        Raises:
            InputError: a frame of another shape than the earlier ones.
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
            before = self._streak.shape
            raise InputError(f"texture frame of {shape} taxels after frames of {before}; equal shapes wanted")

        figures = np.empty((2, *shape))
        self._step(
            np.ascontiguousarray(values), self.floor, self._streak, self._block, self._tails, self._grown, self._head,
            figures,
        )  # fmt: skip
        self._head = (self._head + 1) % self.window
        friction, roughness = figures
        return TextureFigures(friction, roughness, self._streak >= self.window)
