"""The longest path of a trigger wave on a grid, through the worst maze where cells can be walls."""

from math import gcd, lcm

from cnnsim.network import Boundary, Template
from cnnsim.support import Floats

_CROSS = {(-1, 0), (0, -1), (0, 1), (1, 0)}
_RING = {(k, l) for k in (-1, 0, 1) for l in (-1, 0, 1)} - {(0, 0)}


def longest_path(
    template: Template, shape: tuple[int, int], boundary: Boundary, waiting: Floats, has_mask: bool
) -> tuple[int, str]:
    """Return the largest number of cells that a wave can visit one after the other, and the reason.

    ``waiting`` (n, 2) has, for every input that white cells can meet, s - (a - 1) among white neighbours and how much
    that would rise if all real neighbours were black. A cell is set off by nothing (s - (a - 1) > 0), by any one
    neighbour, by several together, or never (a wall). Where one neighbour is always enough, a wave's path touches
    itself nowhere, or it would have taken the short cut. So without walls it is no longer than the distance on the
    grid; with walls a 2 x 2 block holds at most 3 of its cells if neighbours are the 4 beside a cell, and at most 2 if
    they are all 8. Otherwise each cell may have to wait for the one before.
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
    """Return the cells of the longest line if all offsets lie in one, else None.

    On a torus a line is a ring, which a slanted offset, or one that leaves cells out, closes only after many turns.
    Where virtual cells repeat real ones, one that leads out goes on along the edge until it is in the corner; with its
    opposite as well a wave that leaves cells out comes back through them, so that all of the row or column count.
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
