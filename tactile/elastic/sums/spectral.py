"""Traction maps and taxels on one grid: the sum over all cells as a product of Fourier transforms.

Both planes are padded with zeros until no cell sees its neighbour's periodic image, so the result is the direct sum
to rounding. Without padding it would be four times cheaper and wrong by about the size of the map over its period.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from cnnsim.support import Floats, InputError
from tactile.elastic.medium import Medium
from tactile.elastic.sums.cells import point_cell, uniform_cell

CellResponse = Callable[[ArrayLike, ArrayLike, float, float, Medium], Floats]
CELLS: dict[str, CellResponse] = {"point": point_cell, "uniform": uniform_cell}


class TractionTransform:
    """What (rows, cols) taxels feel of tractions on (map_rows, map_cols) cells of the same pitch.

    Arguments: ``map_shape``, ``taxel_shape``; ``pitch`` [m]; ``depth`` [m]; ``offset`` (x, y) [m], the first taxel's
    place minus the first cell's, any number; ``cell``: "point", "uniform", or a function like ``cells.point_cell``.

    Raises:
        InputError: an empty map or array, a pitch that is not positive, an unknown kind of cell.
    """

    def __init__(
        self,
        map_shape: tuple[int, int],
        taxel_shape: tuple[int, int],
        pitch: float,
        depth: float,
        medium: Medium,
        offset: tuple[float, float] = (0.0, 0.0),
        cell: str | CellResponse = "point",
    ) -> None:
        if min(*map_shape, *taxel_shape) < 1 or not (np.isfinite(pitch) and pitch > 0):
            raise InputError(f"{map_shape} cells and {taxel_shape} taxels {pitch} m apart, positive numbers wanted")
        if isinstance(cell, str) and cell not in CELLS:
            raise InputError(f"cell {cell!r}, one of {', '.join(CELLS)} wanted")
        self.map_shape, self.taxel_shape = map_shape, taxel_shape
        size = [fft.next_fast_len(n + m - 1, real=True) for n, m in zip(map_shape, taxel_shape, strict=True)]
        self.size = size[0], size[1]
        response = CELLS[cell] if isinstance(cell, str) else cell
        # index k stands for a taxel k cells on; the last map - 1 indices wrap around to negative distances
        rows, cols = (
            np.where(np.arange(n) < m, np.arange(n), np.arange(n) - n)
            for n, m in zip(self.size, taxel_shape, strict=True)
        )
        kernel = response(offset[0] + cols[None, :] * pitch, offset[1] + rows[:, None] * pitch, depth, pitch, medium)
        self._transfer = fft.rfft2(np.moveaxis(kernel, (-2, -1), (0, 1)), workers=-1)

    def __call__(self, traction: ArrayLike) -> Floats:
        """What the taxels feel, (rows, cols, 3), under a traction map (map_rows, map_cols, 3) [Pa].

        Raises:
            InputError: a map of another shape, or not finite.
        """
        given = np.asarray(traction, dtype=np.float64)
        if given.shape != (*self.map_shape, 3):
            raise InputError(f"traction map of shape {given.shape}, {(*self.map_shape, 3)} wanted")
        if not np.isfinite(given).all():
            raise InputError("a traction map that is not finite, numbers [Pa] wanted")
        waves = fft.rfft2(np.moveaxis(given, -1, 0), s=self.size, workers=-1)
        felt = np.empty((3, *waves.shape[1:]), complex)
        for row, transfer in zip(felt, self._transfer, strict=True):
            np.multiply(transfer[0], waves[0], out=row)
            row += transfer[1] * waves[1]
            row += transfer[2] * waves[2]
        rows, cols = self.taxel_shape
        back = fft.irfft2(felt, s=self.size, workers=-1, overwrite_x=True)[:, :rows, :cols]
        return np.ascontiguousarray(np.moveaxis(back, 0, -1))


def map_loads(traction: ArrayLike, pitch: float, origin: tuple[float, float]) -> Floats:
    """The point loads (cells, 5) of a map (rows, cols, 3) [Pa] whose first cell lies at ``origin`` [m]."""
    given = np.asarray(traction, dtype=np.float64)
    x = origin[0] + np.arange(given.shape[1]) * pitch
    y = origin[1] + np.arange(given.shape[0]) * pitch
    places = np.stack(np.meshgrid(x, y), axis=-1)
    return np.concatenate([places, given * pitch**2], axis=-1).reshape(-1, 5)
