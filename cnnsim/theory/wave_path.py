"""The longest path of a trigger wave on a grid, through the worst maze where cells can be walls."""

from math import gcd, lcm

from cnnsim.network import Boundary, Template
from cnnsim.support import Floats

_CROSS = {(-1, 0), (0, -1), (0, 1), (1, 0)}
_RING = {(k, l) for k in (-1, 0, 1) for l in (-1, 0, 1)} - {(0, 0)}


def longest_path(
    template: Template, shape: tuple[int, int], boundary: Boundary, waiting: Floats, has_mask: bool
) -> tuple[int, str]:
    """Return the largest number of cells that a wave can trigger one after the other, and the reason.

    ``waiting`` (n, 2) has a row for every input of a white cell: s - (a - 1) with white neighbours, and its increase if
    all real neighbours are black. A cell is triggered by no neighbour (s - (a - 1) > 0), by any one neighbour, by
    several together, or never (a wall). If one neighbour is always enough, no two cells of a wave's path are neighbours
    unless they follow each other: otherwise there is a shorter path. So without walls the path is no longer than the
    distance on the grid. With walls a 2 x 2 block holds at most 3 cells of the path if a cell has 4 neighbours, and at
    most 2 if it has 8. If several neighbours are needed, each cell may have to wait for the cell before it.
    """
    rows, cols = shape
    reach = {(tap.k, tap.l): 2 * tap.weight for tap in template.feedback_taps if (tap.k, tap.l) != (0, 0)}
    waiting = waiting[waiting[:, 0] < 0]
    wall = waiting.sum(axis=1) < 0
    if (waiting[~wall, 0] + min(reach.values()) < 0).any():
        return rows * cols, "several neighbours at once, so perhaps one cell after the other"
    maze = has_mask or bool(wall.any())
    line = _line(set(reach), shape, boundary)
    if line is not None:
        return line, "along a line"
    blocks = -(-rows // 2) * -(-cols // 2)
    if set(reach) == _CROSS:
        return (min(3 * blocks, rows * cols), "the worst maze") if maze else (rows + cols - 1, "across the grid")
    if set(reach) == _RING:
        return (min(2 * blocks, rows * cols), "the worst maze") if maze else (max(rows, cols), "across the grid")
    return rows * cols, "all cells, as no shorter path is known"


def _line(offsets: set[tuple[int, int]], shape: tuple[int, int], boundary: Boundary) -> int | None:
    """Return the number of cells of the longest line if all offsets lie on one line, else None.

    On a torus a line is a ring. With an oblique offset, or one of several cells, the ring closes only after several
    turns. Where virtual cells repeat real ones, a wave with an oblique offset continues along the edge to the corner.
    With two opposite offsets of several cells it returns through the cells between, so all cells of the row or column
    count.
    """
    k, l = min(offsets)
    if any(offset not in ((k, l), (-k, -l)) for offset in offsets):
        return None
    along = [(size, abs(part)) for size, part in zip(shape, (k, l), strict=True) if part]
    if boundary.kind == "fixed":
        return min(-(-size // part) for size, part in along)
    if boundary.kind == "periodic":
        return lcm(*(size // gcd(size, part) for size, part in along))
    if len(offsets) == 1:
        return 1 + max(-(-(size - 1) // part) for size, part in along)
    return along[0][0] if len(along) == 1 else None
