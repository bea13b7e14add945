"""Planes on the device: numbers or bits, their shape as kernel arguments, and kernels of per-cell operations."""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.base import Memory
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.network import Frames
from cnnsim.operations.cellwise import Cellwise
from cnnsim.support import InputError

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
        """Lines, rows and columns, for kernels with neighbours."""
        return np.int64(self.lines), np.int32(self.rows), np.int32(self.cols)

    @property
    def flat_arguments(self) -> tuple[np.int64, np.int32]:
        """Lines and columns, for kernels without neighbours."""
        return np.int64(self.lines), np.int32(self.cols)


class LinearPlanes(NamedTuple):
    """State, drive of the input (w = B*u + z + bias) and mask of a linear template."""

    x: Buffer
    w: Buffer
    mask: Buffer | None


@dataclass(frozen=True)
class DevicePlane:
    """A plane on the device: numbers (LAM), or bits in 64-bit words, each row beginning a new word (LLM).

    ``callers``: it is in an array of the caller; ``host``: its copy on the host, rows of numbers or bytes; ``whole``:
    the buffer that it is a part of.
    """

    buffer: Buffer
    shape: tuple[int, ...]
    memory: Memory
    callers: bool = False
    host: Any = field(default=None, compare=False, repr=False)
    whole: Any = field(default=None, compare=False, repr=False)

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
    """Return a plane with any contents."""
    row = shape[-1] * context.dtype.itemsize if memory == "lam" else words_of(shape[-1]) * 8
    return DevicePlane(context.buffer(math.prod(shape[:-1]) * row), shape, memory)


def launch(context: DeviceContext, name: str, work: int, *arguments: Any) -> int:
    """Launch a kernel of planes.cl."""
    return context.launch(context.kernel(name, "planes", {}), work, *arguments)


def buffers(value: DevicePlane | Frames[DevicePlane] | None) -> Any:
    """Return the buffer of a plane, or a sequence of the buffers of a sequence of planes."""
    if isinstance(value, Frames):
        return value.map(lambda plane: plane.buffer)
    return None if value is None else value.buffer


VECTORS = """#ifdef CPU
#ifdef DOUBLE
#define sqrt __builtin_sqrt
#define fabs __builtin_fabs
#else
#define sqrt __builtin_sqrtf
#define fabs __builtin_fabsf
#endif
#pragma clang loop vectorize(assume_safety)
#endif
"""
"""Lets compilers make vectors of the cells on a CPU: PoCL calls functions for its own roots and absolute values, and
forgets `restrict`. One cell at a time takes ten times as long."""


def cellwise_text(operation: Cellwise) -> str:
    """Return a kernel ``cellwise(inputs..., outputs..., parameters..., count)`` around an operation's text.

    Raises:
        InputError: the operation has no OpenCL text.
    """
    if not operation.opencl:
        raise InputError(
            f"cellwise operation {operation.name!r} has no OpenCL text; give it one (`Cellwise.opencl`), "
            "or run on the cpu backend"
        )
    arguments = [f"__global const real *restrict in_{name}" for name in operation.inputs]
    arguments += [f"__global real *restrict out_{name}" for name in operation.outputs]
    arguments += [f"const real {name}" for name in operation.parameters] + ["const long count"]
    lines = [f"const real {name} = in_{name}[cell];" for name in operation.inputs]
    lines += [f"real {name};" for name in operation.outputs]
    stores = [f"out_{name}[cell] = {name};" for name in operation.outputs]
    body = "\n".join((*lines, operation.opencl, *stores))
    return f"KERNEL void cellwise({', '.join(arguments)})\n{{\n{VECTORS}EACH(cell, count) {{\n{body}\n}}\n}}\n"
