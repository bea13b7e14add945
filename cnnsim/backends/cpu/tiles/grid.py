"""Parameters of the Euler loops: tiles of a grid, a template's feedback, the schedule of checks.

Python passes them as bare tuples in this order: numba takes 1.2 us to look up the class of each NamedTuple.
"""

from typing import Any, NamedTuple

from cnnsim.backends.cpu.compiled import helper
from cnnsim.support import Array


class Area(NamedTuple):
    """The cells [r0, r1) x [c0, c1) of a grid."""

    r0: int
    r1: int
    c0: int
    c1: int


class Feedback(NamedTuple):
    """Feedback of a linear template.

    The address of its innermost ``loop``, its taps as records, the nine middle entries of A, the length h of a step;
    its radius, the `BoundaryCode`, and the output of fixed virtual cells.
    """

    loop: int
    taps: Array
    square: Array
    h: Any
    r: int
    code: int
    constant: Any


class Tiling(NamedTuple):
    """The address of the function that steps a tile, steps a pass, rows and columns of a tile, threads."""

    address: int
    depth: int
    height: int
    width: int
    threads: int


class Schedule(NamedTuple):
    """The most steps, steps between two checks (0: none), the rate of a network at rest, and whether a network also
    ends when all cells are saturated for good.
    """

    steps: int
    check_every: int
    rest: Any
    freezes: bool


@helper
def steps_of_pass(done: int, depth: int, schedule: Schedule) -> int:
    """Return how many steps to take before the next check."""
    steps, check_every, _, _ = schedule
    now = min(depth, steps - done)
    return min(now, check_every - done % check_every) if check_every > 0 else now


@helper
def tile_count(shape: tuple[int, int, int], height: int, width: int) -> int:
    """Return the number of tiles of n grids."""
    n, rows, cols = shape
    return n * ((rows + height - 1) // height) * ((cols + width - 1) // width)


@helper
def tile_area(tile: int, shape: tuple[int, int, int], height: int, width: int) -> tuple[int, Area]:
    """Return the grid and the cells of a tile; they are counted row by row, grid by grid."""
    _, rows, cols = shape
    down, across = (rows + height - 1) // height, (cols + width - 1) // width
    r0, c0 = tile // across % down * height, tile % across * width
    return tile // (down * across), Area(r0, min(rows, r0 + height), c0, min(cols, c0 + width))
