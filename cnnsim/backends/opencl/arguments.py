"""Arguments of kernels in named groups: the grid, the planes of a linear template, its taps."""

import math
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.network import Tap, reach


class DeviceGrid(NamedTuple):
    """The shape of planes: ``grids`` of rows x cols cells."""

    grids: int
    rows: int
    cols: int

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> "DeviceGrid":
        """Return planes of a shape (..., rows, cols) as a batch."""
        return cls(math.prod(shape[:-2]), shape[-2], shape[-1])

    @property
    def lines(self) -> int:
        """Rows of all grids."""
        return self.grids * self.rows

    @property
    def cells(self) -> int:
        """Cells of all grids."""
        return self.lines * self.cols

    @property
    def arguments(self) -> tuple[np.int64, np.int32, np.int32]:
        """What kernels with neighbours are told."""
        return np.int64(self.lines), np.int32(self.rows), np.int32(self.cols)

    @property
    def flat_arguments(self) -> tuple[np.int64, np.int32]:
        """What kernels without neighbours are told."""
        return np.int64(self.lines), np.int32(self.cols)


class LinearPlanes(NamedTuple):
    """State, drive of the input (w = B*u + z + bias) and mask of a linear template."""

    x: Buffer
    w: Buffer
    mask: Buffer | None


def tap_arguments(context: DeviceContext, taps: tuple[Tap, ...], outside: float) -> tuple[Any, ...]:
    """Return what a kernel of stencil.cl is told of its taps and of virtual cells that hold a constant."""
    places = [(tap.k, tap.l) for tap in taps]
    weights = np.array([tap.weight for tap in taps] or [0.0], context.dtype)
    numbers = np.int32(len(taps)), np.int32(reach(places)), context.dtype.type(outside)
    return context.table(np.array(places or [(0, 0)], np.int32)), context.table(weights), *numbers
