"""Traction maps on a finger: any distribution of pressure and shear, given on a grid."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, FORCE, PLACE
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import along_path


@dataclass(frozen=True)
class TractionMap:
    """A map that keeps its shape and place and changes in strength.

    Arguments: ``cells`` (n, 5) rows (x, y, Q, R, F) [m, N] of its cells at strength 1; ``path`` (n, 2) rows
    (t, strength) [s, 1].

    Raises:
        InputError: no cells.
    """

    finger: int
    cells: Floats
    path: Floats

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or self.cells.shape[1] != COLUMNS or not len(self.cells):
            raise InputError(f"a traction map of cells {self.cells.shape}, (n, 5) with n of at least 1 wanted")

    def loads(self, times: Floats, depth: float, medium: Medium) -> Loads:
        """The loads on the finger at the times [s]; their total acts in the centre of the pressure."""
        strength, gone = along_path(self.path, times)
        points = np.broadcast_to(self.cells, (len(times), *self.cells.shape)).copy()
        points[..., FORCE] *= np.where(gone, 0, strength[:, 0])[:, None, None]
        size = np.abs(self.cells[:, FORCE]).sum(axis=1)
        centre = np.average(self.cells[:, PLACE], axis=0, weights=size if size.any() else None)
        total = np.concatenate([np.broadcast_to(centre, (len(times), 2)), points[..., FORCE].sum(axis=1)], axis=-1)
        return Loads(total[:, None], points, np.zeros(len(self.cells), np.int64))
