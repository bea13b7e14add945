"""Gain matrices of the taxels, which convert readings to the array's quantity and remove cross-talk of the axes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.frame import NORMAL, Quantity


@dataclass(frozen=True)
class TaxelGains:
    """The linear coefficients of every taxel of an array: u = M (T_x, T_y, S_n), M (3, 3) of its own.

    Arguments: ``matrix`` (rows, cols, 3, 3) [unit of the ``quantity`` per unit of the reading]; ``sigma``: their
    standard deviations, 0 for entries fixed at 0.

    Raises:
        InputError: shapes that do not match, numbers that are not finite, a taxel without a normal gain.
    """

    matrix: Floats
    sigma: Floats
    quantity: Quantity

    def __post_init__(self) -> None:
        if self.matrix.ndim != 4 or self.matrix.shape[2:] != (3, 3) or self.sigma.shape != self.matrix.shape:
            raise InputError(
                f"matrices of shape {self.matrix.shape} and deviations of {self.sigma.shape}, two (rows, cols, 3, 3)"
                " wanted"
            )
        if not (np.isfinite(self.matrix).all() and np.isfinite(self.sigma).all() and self.sigma.min() >= 0):
            raise InputError("matrices or deviations that are no numbers, finite ones and deviations from 0 on wanted")
        if not self._diagonal.all():
            row, col, axis = np.argwhere(self._diagonal == 0)[0].tolist()
            raise InputError(f"taxel ({row}, {col}): gain 0 of its component {axis}, another number wanted")

    @cached_property
    def _diagonal(self) -> Floats:
        return np.diagonal(self.matrix, axis1=2, axis2=3)

    @property
    def normal(self) -> float:
        """Normal gain of the median taxel; its sign is that of the reading of a pressing load."""
        return float(np.median(self._diagonal[..., NORMAL]))

    def __call__(self, values: Floats) -> Floats:
        """Return the quantity (..., rows, cols, 3) of the readings (..., rows, cols, 3)."""
        return np.asarray((self.matrix @ values[..., None])[..., 0])

    def spread(self, sigma: Floats) -> Floats:
        """Return the standard deviations of the quantity for independent errors of the readings."""
        return np.asarray(np.sqrt((self.matrix**2 @ (sigma**2)[..., None])[..., 0]))

    def readings(self, limit: Floats) -> Floats:
        """Return the absolute readings (rows, cols, 3) that correspond to ``limit`` (3,) of the quantity."""
        return np.asarray(limit / np.abs(self._diagonal))
