"""Sum over traction maps on the grid of the taxels by Fourier transforms.

Both planes are padded with zeros so that periodic images do not overlap: the result is the direct sum to rounding.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from cnnsim.support import Floats, InputError, Integers
from tactile.core.loads import COLUMNS, FORCE, PLACE, Q
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct import direct_sum

GRID = 24
"""Fewest taxels along each side from which transforms are faster than the direct sum."""


class TractionTransform:
    """Readings of (rows, cols) taxels under tractions on (map_rows, map_cols) cells of the same pitch.

    Arguments: ``map_shape``, ``taxel_shape``; ``pitch`` [m]; ``depth`` [m]; ``offset`` (x, y) [m], the first taxel's
    place minus the first cell's, any number. A cell's traction acts in its middle: good where the taxels lie deeper
    than about two cells.

    Raises:
        InputError: an empty map or array, a pitch that is not positive.
    """

    def __init__(
        self,
        map_shape: tuple[int, int],
        taxel_shape: tuple[int, int],
        pitch: float,
        depth: float,
        medium: Medium,
        offset: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        if min(*map_shape, *taxel_shape) < 1 or not (np.isfinite(pitch) and pitch > 0):
            raise InputError(f"{map_shape} cells and {taxel_shape} taxels {pitch} m apart, positive numbers wanted")
        self.map_shape, self.taxel_shape = map_shape, taxel_shape
        size = [fft.next_fast_len(n + m - 1, real=True) for n, m in zip(map_shape, taxel_shape, strict=True)]
        self.size = size[0], size[1]
        # index k stands for a taxel k cells on; the last map - 1 indices wrap around to negative distances
        rows, cols = (
            np.where(np.arange(n) < m, np.arange(n), np.arange(n) - n)
            for n, m in zip(self.size, taxel_shape, strict=True)
        )
        x, y = np.meshgrid(offset[0] + cols * pitch, offset[1] + rows * pitch)
        kernel = point_cell(x, y, depth, pitch, medium)
        self._transfer = fft.rfft2(np.moveaxis(kernel, (-2, -1), (0, 1)), workers=-1)

    def __call__(self, traction: ArrayLike) -> Floats:
        """Return the readings (rows, cols, 3) under a traction map (map_rows, map_cols, 3) [Pa].

        Raises:
            InputError: a map of another shape, or not finite.
        """
        given = np.asarray(traction, dtype=np.float64)
        if given.shape != (*self.map_shape, 3):
            raise InputError(f"traction map of shape {given.shape}, {(*self.map_shape, 3)} wanted")
        if not np.isfinite(given).all():
            raise InputError("a traction map that is not finite, numbers [Pa] wanted")
        waves = fft.rfft2(np.moveaxis(given, -1, 0), s=self.size, workers=-1)
        readings = np.empty((3, *waves.shape[1:]), complex)
        for row, transfer in zip(readings, self._transfer, strict=True):
            np.multiply(transfer[0], waves[0], out=row)
            row += transfer[1] * waves[1]
            row += transfer[2] * waves[2]
        rows, cols = self.taxel_shape
        back = fft.irfft2(readings, s=self.size, workers=-1, overwrite_x=True)[:, :rows, :cols]
        return np.ascontiguousarray(np.moveaxis(back, 0, -1))


def map_loads(traction: ArrayLike, pitch: float, origin: tuple[float, float]) -> Floats:
    """Return the point loads (cells, 5) of a map (rows, cols, 3) [Pa] whose first cell lies at ``origin`` [m]."""
    given = np.asarray(traction, dtype=np.float64)
    x = origin[0] + np.arange(given.shape[1]) * pitch
    y = origin[1] + np.arange(given.shape[0]) * pitch
    places = np.stack(np.meshgrid(x, y), axis=-1)
    return np.concatenate([places, given * pitch**2], axis=-1).reshape(-1, 5)


def point_cell(x: ArrayLike, y: ArrayLike, depth: float, pitch: float, medium: Medium) -> Floats:
    """Return the response (..., 3 components, 3 tractions) at (x, y) [m] per Pa on a cell, all of it in its middle."""
    at = np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)), axis=-1)
    unit = np.zeros((3, 1, COLUMNS))
    unit[range(3), 0, range(Q, COLUMNS)] = pitch**2
    return np.moveaxis(direct_sum(at, depth, unit, medium), 0, -1)


def grid_sum(positions: Floats, depth: float, loads: Floats, medium: Medium) -> Floats | None:
    """Return the readings (frames, rows, cols, 3) under loads (frames, n, 5) by transforms.

    None where there are fewer than ``GRID`` taxels or ``GRID`` squared loads, where loads move, or where they do not
    lie whole pitches of the taxels ``positions`` (rows, cols, 2) apart.
    """
    if loads.shape[1] < GRID**2 or positions.ndim != 3 or min(positions.shape[:2]) < GRID or not len(loads):
        return None
    if (loads[..., PLACE] != loads[:1, :, PLACE]).any():
        return None
    pitch = float(positions[0, 1, 0] - positions[0, 0, 0])
    grid = _on_grid(pitch, loads[0, :, PLACE])
    if grid is None:
        return None
    first, shape, index = grid
    x, y = (positions[0, 0] - first).tolist()
    transform = _transform(shape, positions.shape[:2], pitch, depth, medium, (x, y))
    values = np.empty((len(loads), *positions.shape[:2], 3))
    for frame, rows in zip(values, loads, strict=True):
        traction = np.zeros((shape[0] * shape[1], 3))
        np.add.at(traction, index, rows[:, FORCE] / pitch**2)
        frame[:] = transform(traction.reshape(*shape, 3))
    return values


def _on_grid(pitch: float, places: Floats) -> tuple[Floats, tuple[int, int], Integers] | None:
    """(first place, (rows, cols), index of each load) of loads that lie whole pitches apart."""
    first = places.min(axis=0)
    steps = (places - first) / pitch
    cells = np.rint(steps)
    if np.abs(steps - cells).max() > 1e-9 or cells.max() > 4096:
        return None
    cols, rows = (cells.max(axis=0) + 1).astype(int).tolist()
    return first, (rows, cols), (cells[:, 1] * cols + cells[:, 0]).astype(np.int64)


@lru_cache(maxsize=8)
def _transform(
    shape: tuple[int, int], taxels: tuple[int, int], pitch: float, depth: float, medium: Medium,
    offset: tuple[float, float],
) -> TractionTransform:  # fmt: skip
    return TractionTransform(shape, taxels, pitch, depth, medium, offset)
