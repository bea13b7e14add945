"""Summation of point loads: directly, by an influence matrix or by Fourier transforms, and which is the fastest."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.core.frame import TaxelArray
from tactile.core.loads import FORCE, PLACE
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct import direct_sum

Name = Literal["direct", "matrix", "fft"]
FEW = 4
"""With fewer loads a frame the direct sum is as fast as the product with a matrix."""
LARGEST = 1 << 25
"""Most numbers in an influence matrix: 256 MiB."""
GRID = 24
"""From so many cells and taxels a side on the transforms are ahead of the direct sum."""


@dataclass(frozen=True)
class Summation:
    """How the loads are summed, and why so. ``memory``: matrices and transforms already made."""

    name: Name
    why: str
    memory: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    def remember(self, key: Any, make: Any) -> Any:
        """What ``make()`` gave the first time for ``key``."""
        if key not in self.memory:
            self.memory[key] = make()
        return self.memory[key]


DIRECT = Summation("direct", "loads that move, or few of them: every load on every taxel")


def choose_method(array: TaxelArray, loads: Floats, frames: int) -> Summation:
    """Choose the method for ``frames`` frames of point loads like these (samples, n, 5) on an array.

    The matrix where many loads stay where they are over more frames than there are loads; transforms where the loads
    lie on the array's own grid and both are large; else the direct sum.
    """
    count = loads.shape[1]
    if count < FEW or not len(loads) or moving(loads):
        return DIRECT
    if count >= GRID**2 and min(array.shape) >= GRID and _on_grid(array.positions(), loads[0, :, PLACE]) is not None:
        return Summation("fft", f"{count} loads and {array.rows} x {array.cols} taxels on one grid: transforms")
    if frames >= 3 * count and 9 * count * array.rows * array.cols <= LARGEST:
        return Summation("matrix", f"{count} loads that stay in place for {frames} frames: one matrix")
    return DIRECT


def moving(loads: Floats) -> bool:
    """Whether point loads (frames, n, 5) leave the places of the first frame."""
    return bool((loads[..., PLACE] != loads[:1, :, PLACE]).any())


def sum_loads(method: Summation | None, positions: Floats, depth: float, loads: Floats, medium: Medium) -> Floats:
    """What taxels (..., 2) feel of point loads (frames, n, 5): (frames, ..., 3); directly where ``method`` is None.

    Raises:
        InputError: loads that the method cannot carry: moving ones by the matrix, off the taxels' grid by transforms.
    """
    if method is None or method.name == "direct" or not loads.shape[1]:
        return direct_sum(positions, depth, loads, medium)
    if moving(loads):
        raise InputError(f"loads that move, by the {method.name} method; loads that stay in place wanted")
    if method.name == "matrix":
        from tactile.elastic.sums.influence import Influence  # only the method that is taken is imported

        places = np.ascontiguousarray(loads[0, :, PLACE])
        key = positions.tobytes(), depth, places.tobytes(), medium
        return method.remember(key, lambda: Influence(positions, depth, places, medium))(loads[..., FORCE])
    return _by_transforms(method, positions, depth, loads, medium)


def _by_transforms(method: Summation, positions: Floats, depth: float, loads: Floats, medium: Medium) -> Floats:
    from tactile.elastic.sums.spectral import TractionTransform  # only the method that is taken is imported

    grid = _on_grid(positions, loads[0, :, PLACE])
    if grid is None:
        raise InputError("loads and taxels that share no grid, by transforms; loads at whole pitches wanted")
    first, shape, pitch, index = grid
    x, y = (positions[0, 0] - first).tolist()
    taxels = positions.shape[0], positions.shape[1]
    key = taxels, shape, pitch, depth, medium, x, y
    transforms = method.remember(key, lambda: TractionTransform(shape, taxels, pitch, depth, medium, (x, y)))
    values = np.empty((len(loads), *positions.shape[:2], 3))
    for frame, rows in zip(values, loads, strict=True):
        traction = np.zeros((shape[0] * shape[1], 3))
        np.add.at(traction, index, rows[:, FORCE] / pitch**2)
        frame[:] = transforms(traction.reshape(*shape, 3))
    return values


def _on_grid(positions: Floats, places: Floats) -> tuple[Floats, tuple[int, int], float, Integers] | None:
    """(first place, (rows, cols), pitch, index of each load) of loads that lie whole taxel pitches apart."""
    if positions.ndim != 3 or positions.shape[1] < 2:
        return None
    pitch = float(positions[0, 1, 0] - positions[0, 0, 0])
    first = places.min(axis=0)
    steps = (places - first) / pitch
    cells = np.rint(steps)
    if np.abs(steps - cells).max() > 1e-9 or cells.max() > 4096:
        return None
    cols, rows = (cells.max(axis=0) + 1).astype(int).tolist()
    index = (cells[:, 1] * cols + cells[:, 0]).astype(np.int64)
    return first, (rows, cols), pitch, index
