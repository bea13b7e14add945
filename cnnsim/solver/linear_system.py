"""Linear system of a template on a grid: the sparse matrix of A with its virtual cells, and the drive w."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cnnsim.network import Boundary, Tap
from cnnsim.network.boundary import virtual_index
from cnnsim.network.weights import reach
from cnnsim.solver.spectrum import Inverse, is_definite, spectral_inverse
from cnnsim.support import Flags, Floats


@dataclass(frozen=True)
class LinearSystem:
    """dx/dt = -x + A y + w in the ``free`` cells and 0 in the others, all cells of a grid in one row.

    ``matrix`` (cells, cells) is A as a sparse matrix, to which virtual cells that repeat real ones belong; ``drive``
    (cells,) is w = B*u + z + bias and the part of virtual cells of constant output. ``inverse``: an approximate inverse
    of I - A; ``definite``: no mode grows for any set of free cells.
    """

    matrix: Any
    drive: Floats
    free: Flags
    inverse: Inverse | None = None
    definite: bool = False

    def with_planes(self, drive: Floats, free: Flags) -> "LinearSystem":
        """Return the same A with another w (cells,), to which the virtual cells are added, and other free cells."""
        return replace(self, drive=self.drive + drive, free=free)


def linear_system(taps: tuple[Tap, ...], shape: tuple[int, int], boundary: Boundary) -> LinearSystem:
    """Return the system of the taps of A on a grid (rows, cols), with w = 0 but for the virtual cells."""
    from scipy.sparse import coo_matrix  # slow to import, and only needed where an accuracy is asked for

    rows, cols = shape
    cells, r = rows * cols, reach((k, l) for k, l, _ in taps)
    row_of, col_of = virtual_index(rows, r, boundary), virtual_index(cols, r, boundary)
    here = np.arange(cells)
    at: list[Any] = []
    drive = np.zeros(cells)
    for k, l, weight in taps:
        row, col = row_of[r + k : r + k + rows, None], col_of[None, r + l : r + l + cols]
        there = np.where((row < 0) | (col < 0), -1, row * cols + col).ravel()
        real = there >= 0
        drive[~real] += weight * boundary.y
        at.append((here[real], there[real], np.full(int(real.sum()), weight)))
    i, j, values = (np.concatenate(part) for part in zip(*at, strict=True)) if at else (here[:0], here[:0], drive[:0])
    return LinearSystem(
        coo_matrix((values, (i, j)), (cells, cells)).tocsr(),
        drive,
        np.ones(cells, bool),
        spectral_inverse(taps, shape, boundary),
        is_definite(taps, boundary),
    )
