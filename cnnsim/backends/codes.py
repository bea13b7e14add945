"""The numbers by which compiled loops and OpenCL text know tasks, functions and boundaries."""

from enum import IntEnum

from cnnsim.network import Boundary

NOTHING = -1
"""No channel, no plane of weights."""


class BoundaryCode(IntEnum):
    """What lies around the grid; see `Boundary`."""

    FIXED = 0
    ZERO_FLUX = 1
    PERIODIC = 2


def boundary_code(boundary: Boundary) -> BoundaryCode:
    """Return the number of a boundary, which has its kind as its name."""
    return BoundaryCode[boundary.kind.upper().replace("-", "_")]


class FunctionCode(IntEnum):
    """A function of one variable. A step belongs to what is beyond its place, never to the place itself."""

    IDENTITY = 0
    LINEAR = 1
    STEP = 2
    CLIP = 3
    SIGN = 4
    TANH = 5


class TaskCode(IntEnum):
    """What a loop over the cells does with their drives.

    DRIVE: write them; RATE: write the drives less the state (OpenCL's alone); DISCRETE: write the outputs that they
    make; STEP: take a step, on OpenCL of a one-stage scheme; CHECK: write the largest rate (the cpu backend's alone).
    """

    DRIVE = 0
    RATE = 1
    DISCRETE = 2
    STEP = 3
    CHECK = 4
