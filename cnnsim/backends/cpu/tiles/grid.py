"""Groups of numbers for the Euler loops: tiles of a grid, a template's feedback, the schedule of checks."""

from typing import Any, NamedTuple

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array


class Area(NamedTuple):
    """The cells [r0, r1) x [c0, c1) of a grid."""

    r0: int
    r1: int
    c0: int
    c1: int


class Edge(NamedTuple):
    """What lies around the grid, ``r`` cells deep: a `BoundaryCode`, and what fixed virtual cells hold."""

    r: int
    code: int
    constant: Any


class Feedback(NamedTuple):
    """A template's feedback: the address of its innermost ``loop``, its taps as records, the nine middle entries of A,
    the length of a step, and the fields of the `Edge` of the grid (threaded loops take no group within a group).

    A step of so many ``stages`` has its scheme's table in place of the entries of A (0: a fused Euler step); ``lives``
    are the sets of live rows that it needs (see `TileLayout`), ``limited`` is whether states stay within +-1.
    """

    loop: int
    taps: Array
    numbers: Array
    h: Any
    r: int
    code: int
    constant: Any
    stages: int
    lives: int
    limited: bool


class Tiling(NamedTuple):
    """How a grid is worked through: the address of what steps a tile, steps a pass, rows and columns, threads."""

    address: int
    depth: int
    height: int
    width: int
    threads: int


class Schedule(NamedTuple):
    """When to stop: at most so many steps, with a check every so many (0: never), for rates of ``rest`` or less, or
    (``freezes``) when all cells are saturated for good.
    """

    steps: int
    check_every: int
    rest: float
    freezes: bool


@helper
def levels_of(steps: int, feedback: Feedback) -> int:
    """Return how many levels the rows of a tile go through in so many steps: one a stage."""
    return steps * max(1, feedback[7])


@helper
def steps_of_pass(done: int, depth: int, schedule: Schedule) -> int:
    """Return how many steps to take before the next check."""
    steps, check_every, _, _ = schedule
    now = min(depth, steps - done)
    return min(now, check_every - done % check_every) if check_every > 0 else now


@helper
def tile_count(shape: tuple[int, int, int], height: int, width: int) -> int:
    """Return into how many tiles n grids are cut."""
    n, rows, cols = shape
    return n * ((rows + height - 1) // height) * ((cols + width - 1) // width)


@helper
def tile_area(tile: int, shape: tuple[int, int, int], height: int, width: int) -> tuple[int, Area]:
    """Return the grid and the cells of a tile; they are counted row by row, grid by grid."""
    _, rows, cols = shape
    down, across = (rows + height - 1) // height, (cols + width - 1) // width
    r0, c0 = tile // across % down * height, tile % across * width
    return tile // (down * across), Area(r0, min(rows, r0 + height), c0, min(cols, c0 + width))
