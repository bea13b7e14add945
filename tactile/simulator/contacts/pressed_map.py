"""Solution of a pressed height map: force law and pressures, on cells refined to the contact's size."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from cnnsim.support import Flags, Floats
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.height_surface import HeightSurface, touching

LEVELS = 17
"""Indentations at which pressures are solved, denser near first contact; in between they are linear in the force."""
BETWEEN = 16
"""Points of the law of force and indentation per solved indentation, by cubic interpolation."""
ACROSS = 7.0
"""Cells in a contact's radius for which a ball's force is good to 0.5 % wherever it lies, and its field to half of
that."""
MOST = 1 << 15
"""Most cells on which a map is solved, unless it has more itself."""
FINER = 4.0
"""Largest refinement in one step: the contact is known only as well as its cells are small."""
SHALLOWEST = 1e-6
"""Smallest indentation over a cell's width, well above the rounding of heights."""
SEARCH = 60
"""Most steps to the indentation under a force; half a dozen are usual."""


@dataclass(frozen=True, eq=False)
class PressedMap:
    """Pressures under a map up to its deepest indentation.

    ``deep`` and ``force`` (n,) [m, N]: the law; ``places`` (cells, 2) [m] of the cells that are pressed, from the map's
    middle; ``forces`` (levels, cells) [N] on them; ``pitch`` [m] of these cells; ``width`` [m]: twice the
    deepest contact's ``radius_in_cells``; ``doubt``: the relative uncertainty of the deepest force from the map's own
    cells, about.
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
    for n in range(1, LEVELS - 1):  # first guess: extrapolated from the last two
        ahead = 0.0 if n == 1 else (deep[n] - deep[n - 1]) / (deep[n - 1] - deep[n - 2])
        start = np.maximum(levels[-1] + ahead * (levels[-1] - levels[-2]), 0.0)
        box, level = touching(contact.gap < deep[n], parts), np.zeros_like(last)
        level[box] = contact.part(box).pressed(float(deep[n]), start[box])
        levels.append(contact.pressed(float(deep[n]), level))  # converged where nothing beyond the box touches
    levels = [*levels[1:], last]
    forces = np.stack(levels) * grid.pitch**2
    pressed = np.asarray(forces.any(axis=0))
    if not pressed.any():
        pressed.flat[int(contact.gap.argmin())] = True
    dense = np.linspace(0, 1, (LEVELS - 1) * BETWEEN + 1)  # in the root of the indentation laws are smooth
    force = PchipInterpolator(np.linspace(0, 1, LEVELS), forces.sum(axis=(1, 2)))(dense)
    doubt = max(
        _between_cells(surface, medium, deepest, parts, float(force[-1])),
        _at_walls(contact.gap, levels[-1] > 0, deepest) * parts,
    )
    width = 2 * across * grid.pitch
    return PressedMap(deepest * dense**2, force, grid.places(pressed), forces[:, pressed], grid.pitch, width, doubt)


def _depth_of(surface: HeightSurface, parts: int, medium: Medium, force: float, start: float) -> float:
    """Return an indentation whose force is up to 1.1 times this one, by a power law through the last two."""
    deep, power, low, high = start, 1.5, (0.0, 0.0), np.inf
    for _ in range(SEARCH):
        got = surface.force(deep, parts, medium)
        if force <= got <= 1.1 * force or (got > force and deep <= SHALLOWEST * surface.pitch):
            break
        if got < force and deep >= 0.999 * medium.thickness:
            deep = medium.thickness  # refused by RoughContact.pressed
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
    """Return the uncertainty between cells: a quarter of the force's change when every second cell is left out.

    Half the pitch reduces the error to a quarter on surfaces with kinks, and more on smooth ones.
    """
    if min(surface.heights.shape) < 4:
        return 1.0
    halves = [HeightSurface(surface.heights[k::2, k::2], 2 * surface.pitch) for k in (0, 1)]
    coarse = [half.force(deep, min(2 * parts, _finest(half, deep)), medium) for half in halves]
    return min(max(abs(one / max(force, 1e-300) - 1) for one in coarse) / 4, 1.0)


def _finest(surface: HeightSurface, deep: float) -> int:
    """Return the most parts of a cell for which the touching area has at most ``MOST``."""
    return max(1, int(np.sqrt(MOST / surface.grid(deep, 1).size)))


def _at_walls(gap: Floats, pressed: Flags, deep: float) -> float:
    """Return the uncertainty of a contact that ends at walls or at the border, for cells as wide as those of the gap.

    A wall lies anywhere between two cells, off by a quarter of a cell on average, and the force is proportional to the
    radius: a quarter of a cell of it for a circle with a wall all around.
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
    """Return twice the area of a contact over its outline, in cells: the radius, or a typical one of several."""
    padded = np.pad(pressed, 1)
    sides = sum(int(np.count_nonzero(np.diff(padded, axis=axis))) for axis in (0, 1))
    # the sides of cells are 4 / pi times as long as a slanting outline
    return 8 / np.pi * np.count_nonzero(pressed) / sides if sides else 0.0
