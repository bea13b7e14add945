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

    DRIVE: write them; DISCRETE: write the outputs that they make; STEP: take a step of all stages; CHECK: hand in the
    largest rate.
    """

    DRIVE = 0
    DISCRETE = 1
    STEP = 2
    CHECK = 3
