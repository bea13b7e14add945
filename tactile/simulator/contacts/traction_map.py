"""Traction map: a given distribution of pressure and shear on a grid of a finger."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, FORCE, PLACE, F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.mounting import STILL, Rig
from tactile.simulator.contacts.moving_load import along_path


@dataclass(frozen=True, eq=False)  # arrays are not compared
class TractionMap:
    """A map that keeps its shape and place and changes in strength; its tractions may pull.

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

    @cached_property
    def body(self) -> Indenter:
        """A flat punch of the same area, by whose stiffness a mounting holds the map."""
        steps = np.diff(np.unique(self.cells[self.cells[:, F] > 0, : PLACE.stop][:, 0]))
        if not steps.size:
            return Indenter()
        area = float(steps.min()) ** 2 * np.count_nonzero(self.cells[:, F] > 0)
        return Indenter("flat_punch", float(np.sqrt(area / np.pi)))

    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        """Return the loads on the finger at the times [s]; their total acts in the centre of the tractions."""
        strength, gone = along_path(self.path, times)
        points = np.broadcast_to(self.cells, (len(times), *self.cells.shape)).copy()
        points[..., FORCE] *= np.where(gone, 0, strength[:, 0])[:, None, None]
        size = np.abs(self.cells[:, FORCE]).sum(axis=1)
        centre = np.average(self.cells[:, PLACE], axis=0, weights=size if size.any() else None)
        total = np.concatenate([np.broadcast_to(centre, (len(times), 2)), points[..., FORCE].sum(axis=1)], axis=-1)
        if rig.moves:
            held = rig.moved(total, self.body, medium)
            points[..., PLACE] += (held - total)[:, None, PLACE]
            pressing = total[:, F] != 0
            points[..., FORCE] *= np.where(pressing, held[:, F] / np.where(pressing, total[:, F], 1), 1)[:, None, None]
            total = held
        return Loads(total[:, None], points, np.zeros(len(self.cells), np.int64))
