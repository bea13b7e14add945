"""Codes of tasks, functions and boundaries in compiled loops and OpenCL text."""

from enum import IntEnum

from cnnsim.network import Boundary
from cnnsim.support import InputError

NOTHING = -1
"""No channel, no plane of weights."""


class BoundaryCode(IntEnum):
    """A boundary; see `Boundary`."""

    FIXED = 0
    ZERO_FLUX = 1
    PERIODIC = 2


def boundary_code(boundary: Boundary) -> BoundaryCode:
    """Return the code of a boundary.

    Raises:
        InputError: a boundary that compiled loops do not have.
    """
    if boundary.kind == "reflecting":
        raise InputError(f"a {boundary} boundary on a compiled backend; backend = 'reference' wanted")
    return BoundaryCode[boundary.kind.upper().replace("-", "_")]


class FunctionCode(IntEnum):
    """A function of one variable. At the place of a step the value is that before it."""

    IDENTITY = 0
    LINEAR = 1
    STEP = 2
    CLIP = 3
    SIGN = 4
    TANH = 5


class TaskCode(IntEnum):
    """Task of a loop over the cells.

    DRIVE: write the drives; DISCRETE: write the outputs of the drives; STEP: take steps; CHECK: find the largest rate.
    """

    DRIVE = 0
    DISCRETE = 1
    STEP = 2
    CHECK = 3
