"""A height map pressed onto a cover: its laws and pressures, on cells as small as its contact asks for."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from cnnsim.support import Flags, Floats
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.height_surface import HeightSurface, touching

LEVELS = 17
"""Indentations at which pressures are solved, closer where the contact begins; in between they are straight in the
force."""
BETWEEN = 16
"""Places from one of them to the next in the law of force and indentation, which is a cubic in between."""
ACROSS = 7.0
"""Cells in a contact's radius: a ball's force is good to 0.5 % then, wherever it lies on the cells, its field to half
of that."""
MOST = 1 << 15
"""Cells at most on which a map is solved, unless it has more itself."""
FINER = 4.0
"""Times, at most, by which cells get smaller at once: what is known of the contact is as coarse as its cells are."""
SHALLOWEST = 1e-6
"""Of a cell's width: the shallowest indentation that is looked for, well above the rounding of heights."""
SEARCH = 60
"""Steps for the indentation under a force; half a dozen are usual."""


@dataclass(frozen=True, eq=False)
class PressedMap:
    """Pressures under a map up to its deepest indentation.

    ``deep`` and ``force`` (n,) [m, N]: the law; ``places`` (cells, 2) [m] of the cells that are pressed, from the map's
    middle; ``forces`` (levels, cells) [N] on them; ``pitch`` [m] of these cells; ``width`` [m]: the diameter of the
    deepest contact, as ``radius_in_cells`` has it; ``doubt``: by about what share of the deepest force the map's own
    cells, not these, leave it open.
    """

    deep: Floats
    force: Floats
    places: Floats
    forces: Floats
    pitch: float
    width: float
    doubt: float


def press(heights: Floats, pitch: float, medium: Medium, most: float, by_depth: bool) -> PressedMap:
    """Press a map of ``heights`` (rows, cols) [m], cells of a ``pitch`` [m], up to a force [N] or an indentation [m].

    Raises:
        InputError: as ``rough_contact.RoughContact.pressed``.
    """
    surface, parts = HeightSurface(heights, pitch), 1
    deepest = max(most, 1e-9) * 1.05 if by_depth else pitch / 100
    while True:
        if most > 0 and not by_depth:
            deepest = _depth_of(surface, parts, medium, most, deepest)
        grid, contact, last = surface.pressed(deepest, parts, medium)
        across = radius_in_cells(last > 0)
        finest = _finest(surface, deepest)
        if across >= ACROSS or parts >= finest:
            break
        parts = min(finest, int(np.ceil(parts * min(FINER, ACROSS / max(across, 1e-3)))))
    deep, levels = deepest * np.linspace(0, 1, LEVELS) ** 2, [np.zeros_like(last)] * 2
    for n in range(1, LEVELS - 1):  # begun at what the two before lead on to
        ahead = 0.0 if n == 1 else (deep[n] - deep[n - 1]) / (deep[n - 1] - deep[n - 2])
        start = np.maximum(levels[-1] + ahead * (levels[-1] - levels[-2]), 0.0)
        box, level = touching(contact.gap < deep[n], parts), np.zeros_like(last)
        level[box] = contact.part(box).pressed(float(deep[n]), start[box])
        levels.append(contact.pressed(float(deep[n]), level))  # at once where none beyond the box is touched
    levels = [*levels[1:], last]
    forces = np.stack(levels) * grid.pitch**2
    pressed = np.asarray(forces.any(axis=0))
    if not pressed.any():
        pressed.flat[int(contact.gap.argmin())] = True
    dense = np.linspace(0, 1, (LEVELS - 1) * BETWEEN + 1)  # the root of the indentation, in which laws are smooth
    force = PchipInterpolator(np.linspace(0, 1, LEVELS), forces.sum(axis=(1, 2)))(dense)
    doubt = max(
        _between_cells(surface, medium, deepest, parts, float(force[-1])),
        _at_walls(contact.gap, levels[-1] > 0, deepest) * parts,
    )
    width = 2 * across * grid.pitch
    return PressedMap(deepest * dense**2, force, grid.places(pressed), forces[:, pressed], grid.pitch, width, doubt)


def _depth_of(surface: HeightSurface, parts: int, medium: Medium, force: float, start: float) -> float:
    """An indentation that takes a little more than this force: by powers of what was found last."""
    deep, power, low, high = start, 1.5, (0.0, 0.0), np.inf
    for _ in range(SEARCH):
        got = surface.force(deep, parts, medium)
        if force <= got <= 1.1 * force or (got > force and deep <= SHALLOWEST * surface.pitch):
            break
        if got < force and deep >= 0.999 * medium.thickness:
            deep = medium.thickness  # goes through, which is refused where it is pressed
            continue
        if got < force:
            if low[1] > 0:
                power = min(max(np.log(got / low[1]) / np.log(deep / low[0]), 1.0), 6.0)
            low = deep, got
        else:
            high = deep
        after = deep * min(max((1.05 * force / max(got, 1e-300)) ** (1 / power), 0.25), 4.0)
        if np.isfinite(high) and not low[0] < after < high:
            after = np.sqrt(max(low[0], high / 16) * high)
        deep = min(max(float(after), SHALLOWEST * surface.pitch), 0.999 * medium.thickness)
    return deep


def _between_cells(surface: HeightSurface, medium: Medium, deep: float, parts: int, force: float) -> float:
    """What is not known of a smooth surface: a quarter of what every second cell makes of the force [N] at a depth.

    Cells half as wide make a quarter of the error of a surface with kinks, less of a smooth one.
    """
    if min(surface.heights.shape) < 4:
        return 1.0
    halves = [HeightSurface(surface.heights[k::2, k::2], 2 * surface.pitch) for k in (0, 1)]
    told = [half.force(deep, min(2 * parts, _finest(half, deep)), medium) for half in halves]
    return min(max(abs(one / max(force, 1e-300) - 1) for one in told) / 4, 1.0)


def _finest(surface: HeightSurface, deep: float) -> int:
    """Into how many parts a cell may be cut so that where it can touch there are not too many."""
    return max(1, int(np.sqrt(MOST / surface.grid(deep, 1).size)))


def _at_walls(gap: Floats, pressed: Flags, deep: float) -> float:
    """What is not known of a contact that ends at walls or at the border, for cells as wide as those of the gap.

    A wall lies anywhere between two cells, a quarter of one off as a rule, and the force grows like the contact's
    radius: a quarter of a cell in it for a circle, all of whose outline is wall.
    """
    if not pressed.any():
        return 0.0
    padded, held, sides = np.pad(gap, 1, constant_values=np.inf), np.pad(pressed, 1), 0
    for axis in (0, 1):
        for step in (1, -1):
            sides += int(np.count_nonzero(held & (np.roll(padded, step, axis) > deep + np.where(held, padded, 0.0))))
    # of a circle: 8 r sides around pi r^2 cells
    return float(np.pi / 32 * sides / np.count_nonzero(pressed))


def radius_in_cells(pressed: Flags) -> float:
    """Twice the area of a contact over its outline, in cells: the radius of a circle, or of a typical one of many."""
    padded = np.pad(pressed, 1)
    sides = sum(int(np.count_nonzero(np.diff(padded, axis=axis))) for axis in (0, 1))
    # along a slanting outline the sides of cells are 4 / pi times as long as it is
    return 8 / np.pi * np.count_nonzero(pressed) / sides if sides else 0.0
