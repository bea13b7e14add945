"""The influence matrix of loads that stay in place, put together once and multiplied with many frames."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, PLACE, Q
from tactile.elastic.layer_loads import layered_load
from tactile.elastic.medium import Medium


class Influence:
    """What the taxels feel of unit loads at fixed places: a matrix of 3 rows a taxel and 3 columns a place.

    Arguments: ``positions`` (..., 2) taxel centres [m]; ``depth`` [m]; ``places`` (n, 2) of the loads [m].

    Raises:
        InputError: places of another shape, and as ``halfspace.point_load``.
    """

    def __init__(self, positions: ArrayLike, depth: float, places: ArrayLike, medium: Medium) -> None:
        where = np.asarray(places, dtype=np.float64)
        if where.ndim != 2 or where.shape[1] != 2:
            raise InputError(f"places of shape {where.shape}, (n, 2) wanted")
        at = np.asarray(positions, dtype=np.float64)
        self.shape = at.shape[:-1]
        unit = np.zeros((len(where), 3, 1, COLUMNS))
        unit[..., 0, PLACE] = where[:, None]
        unit[:, range(3), 0, range(Q, COLUMNS)] = 1
        felt = layered_load(at.reshape(-1, 1, 1, 2), depth, unit, medium)  # (taxels, n, 3 forces, 3 components)
        self.matrix = np.ascontiguousarray(felt.reshape(-1, 3 * len(where), 3).transpose(1, 0, 2)).reshape(
            3 * len(where), -1
        )

    def __call__(self, forces: ArrayLike) -> Floats:
        """What the taxels feel under forces (frames, n, 3), components (Q, R, F) [N]: (frames, ..., 3).

        Raises:
            InputError: forces that do not fit the places, or are not finite.
        """
        given = np.asarray(forces, dtype=np.float64)
        if given.ndim != 3 or given.shape[1] * given.shape[2] != len(self.matrix) or given.shape[2] != 3:
            raise InputError(f"forces of shape {given.shape}, (frames, {len(self.matrix) // 3}, 3) wanted")
        if not np.isfinite(given).all():
            raise InputError("forces that are not finite, numbers (Q, R, F) wanted")
        felt: Floats = given.reshape(len(given), -1) @ self.matrix
        return felt.reshape(len(given), *self.shape, 3)
