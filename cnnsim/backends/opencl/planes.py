"""Planes on the device: numbers or bits, and what kernels are told of their shape."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.base import Memory
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.network import Frames

WORD = 64
"""Cells of an LLM plane in a word."""


class DeviceGrid(NamedTuple):
    """The shape of planes: ``grids`` of rows x cols cells."""

    grids: int
    rows: int
    cols: int

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


@dataclass(frozen=True)
class DevicePlane:
    """A plane on the device: numbers (LAM), or bits in 64-bit words, a row beginning a new word (LLM)."""

    buffer: Buffer
    shape: tuple[int, ...]
    memory: Memory

    @property
    def grid(self) -> DeviceGrid:
        """The shape as a batch."""
        return DeviceGrid(math.prod(self.shape[:-2]), *self.shape[-2:])

    @property
    def words(self) -> int:
        """Words of an LLM plane."""
        return self.grid.lines * words_of(self.shape[-1])


def words_of(cols: int) -> int:
    """Return the words in a row of an LLM plane."""
    return -(-cols // WORD)


def new_plane(context: DeviceContext, shape: tuple[int, ...], memory: Memory) -> DevicePlane:
    """Return a plane that holds anything, in memory that comes back when nobody has the plane any more."""
    row = shape[-1] * context.dtype.itemsize if memory == "lam" else words_of(shape[-1]) * 8
    plane = DevicePlane(context.buffer(math.prod(shape[:-1]) * row), shape, memory)
    context.lend(plane, plane.buffer)
    return plane


def launch(context: DeviceContext, name: str, work: int, *arguments: Any) -> int:
    """Launch a kernel of planes.cl."""
    return context.launch(context.kernel(name, "planes", {}), work, *arguments)


def buffers(value: DevicePlane | Frames[DevicePlane] | None) -> Any:
    """Return what a plane, or each plane of a sequence, is on the device."""
    if isinstance(value, Frames):
        return value.map(lambda plane: plane.buffer)
    return None if value is None else value.buffer
