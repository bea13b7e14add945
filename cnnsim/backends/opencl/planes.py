"""Planes on the device: numbers or bits, how they come in and go out, and kernels that take them as a whole."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pyopencl as cl

from cnnsim.backends.base import Memory
from cnnsim.backends.opencl.context import Buffer, DeviceContext
from cnnsim.network import Frames
from cnnsim.support import Array

_WORD = 64  # cells of an LLM plane in a word


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
    return -(-cols // _WORD)


def new_plane(context: DeviceContext, shape: tuple[int, ...], memory: Memory) -> DevicePlane:
    """Return a plane that holds anything."""
    row = shape[-1] * context.dtype.itemsize if memory == "lam" else words_of(shape[-1]) * 8
    return DevicePlane(context.buffer(math.prod(shape[:-1]) * row), shape, memory)


def load(context: DeviceContext, values: Array, memory: Memory) -> DevicePlane:
    """Bring an array to the device; into an LLM everything above 0 is black."""
    if memory == "lam":
        host: Array = np.ascontiguousarray(values, dtype=context.dtype)
    else:
        host = np.zeros((*values.shape[:-1], words_of(values.shape[-1]) * 8), np.uint8)
        packed = np.packbits(values > 0, axis=-1, bitorder="little")
        host[..., : packed.shape[-1]] = packed
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    return DevicePlane(cl.Buffer(context.context, flags, hostbuf=host), values.shape, memory)


def read(context: DeviceContext, plane: DevicePlane) -> Array:
    """Bring a plane back as an array."""
    if plane.memory == "lam":
        numbers = np.empty(plane.shape, context.dtype)
        cl.enqueue_copy(context.queue, numbers, plane.buffer)
        return numbers
    words = np.empty((*plane.shape[:-1], words_of(plane.shape[-1]) * 8), np.uint8)
    cl.enqueue_copy(context.queue, words, plane.buffer)
    return np.unpackbits(words, axis=-1, count=plane.shape[-1], bitorder="little").astype(bool)


def convert(context: DeviceContext, plane: DevicePlane, memory: Memory) -> DevicePlane:
    """Return the plane for the other memory."""
    out = new_plane(context, plane.shape, memory)
    launch(context, f"to_{memory}", plane.words * _WORD, plane.buffer, out.buffer, *plane.grid.flat_arguments)
    return out


def count(context: DeviceContext, plane: DevicePlane) -> Any:
    """Return how many cells of an LLM plane are black: a number, or (n,) numbers for n grids."""
    if len(plane.shape) == 3:
        grids = plane.shape[0]
        totals, each = np.empty(grids, np.int64), context.buffer(8 * grids)
        launch(context, "count_each", plane.words, plane.buffer, each, np.int64(grids), np.int32(plane.words // grids))
        cl.enqueue_copy(context.queue, totals, each)
        return totals
    parts = launch(context, "count_black", plane.words, plane.buffer, context.partial, np.int64(plane.words))
    return int(context.parts(parts, np.dtype(np.uint64)).sum())


def all_finite(context: DeviceContext, plane: DevicePlane) -> bool:
    """Return whether a LAM plane holds finite numbers only."""
    cells = plane.grid.cells
    parts = launch(context, "finite", cells, plane.buffer, context.partial, np.int64(cells))
    return not context.parts(parts, context.dtype).any()


def launch(context: DeviceContext, name: str, work: int, *arguments: Any) -> int:
    """Launch a kernel of planes.cl."""
    return context.launch(context.kernel(name, "planes", {}), work, *arguments)


def buffers(value: DevicePlane | Frames[DevicePlane] | None) -> Any:
    """Return what a plane, or each plane of a sequence, is on the device."""
    if isinstance(value, Frames):
        return value.map(lambda plane: plane.buffer)
    return None if value is None else value.buffer
