"""Height map: a rigid body of any shape that moves over a finger, pressed by force or by depth."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cnnsim.support import Flags, Floats, InputError, Integers
from tactile.core.loads import COLUMNS, FORCE, PLACE, SHEAR, F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.load_pattern import LoadPattern, PatternLoads
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.mounting import STILL, Rig, sum_of
from tactile.simulator.contacts.moving_contact import limited_shear
from tactile.simulator.contacts.moving_load import along_path, checked_path, span
from tactile.simulator.contacts.pressed_map import BETWEEN, PressedMap, press

LAST = 0.9
"""Largest share of a layer's thickness at which solutions for deeper indentations double the last one."""


@dataclass(frozen=True, eq=False, repr=False)  # arrays are not compared
class HeightMap:
    """A rigid body with an underside of ``heights`` (rows, cols) [m], cells of a ``pitch`` [m].

    ``path`` (n, 6) rows (t, x, y, Q, R, push) [s, m, m, N, N, N or m] of the map's middle, ``push`` the normal force
    or, where ``given_depth``, the indentation of its lowest point. Shear is spread like the pressure; with ``friction``
    the whole contact slips at once. A body that is pulled lifts off.
    """

    finger: int
    heights: Floats
    pitch: float
    path: Floats
    friction: float | None = None
    given_depth: bool = False
    memory: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", checked_path(self.path, 1 + COLUMNS, "height map"))

    def __repr__(self) -> str:
        rows, cols = self.heights.shape
        return f"HeightMap(finger={self.finger}, {rows} x {cols}, {span(self.path)})"

    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        """Return the loads on the finger at the times [s], for taxels at ``depth`` [m], with the body in the rig.

        Raises:
            InputError: cells wider than half the depth; as ``rough_contact.RoughContact.pressed``.
        """
        if rig.curvature:
            return self.on_dome(rig.curvature).loads(times, depth, medium, replace(rig, curvature=0.0))
        if self.pitch > depth / 2 * (1 + 1e-9):
            raise InputError(
                f"a height map of cells {self.pitch * 1e3:g} mm wide over taxels {depth * 1e3:g} mm deep; at most half"
                " the depth wanted"
            )
        rows, gone = along_path(self.path, times)
        rows[gone, PLACE.stop :] = 0
        if self.given_depth:
            rows[rows[:, F] < 0, SHEAR] = 0
        rows, solutions = self._held(rows, medium, rig)
        rows[rows[:, F] < 0, PLACE.stop :] = 0
        if self.friction is not None:
            rows[:, SHEAR] = limited_shear(rows, self.friction)
        owner = np.zeros(1, np.int64)
        spread = tuple(self._spread(rows, here, medium, depth, most, owner) for most, here in solutions)
        return Loads(rows[:, None], np.empty((len(rows), 0, COLUMNS)), owner[:0], patterns=spread)

    def on_dome(self, curvature: float) -> "HeightMap":
        """Return the map that touches a plane as this one touches a cover curved about its middle [1/m]."""
        if curvature == 0:
            return self
        if ("dome", curvature) not in self.memory:
            y, x = ((np.arange(count) - (count - 1) / 2) * self.pitch for count in self.heights.shape)
            higher = self.heights + curvature / 2 * (x**2 + y[:, None] ** 2)
            self.memory["dome", curvature] = replace(self, heights=higher, memory={})
        curved: HeightMap = self.memory["dome", curvature]
        return curved

    def _held(self, rows: Floats, medium: Medium, rig: Rig) -> tuple[Floats, list[tuple[float | None, Flags]]]:
        """Return rows (frames, 5) with the forces in the rig; and solutions (`pressed`) with the frames that use them.

        Frames raised beyond the path's indentation use a solution for twice, four times, ... of it, each frame on its
        own, so that results do not depend on how frames are cut into pieces.
        """
        rows, rises = rig.displaced(rows)
        if not rises:
            return self._forces(rows, 0.0, self.pressed(medium)), [(None, np.ones(len(rows), bool))]
        rise, most, held = sum_of(rises), None, np.empty_like(rows)
        solutions: list[tuple[float | None, Flags]] = []
        left = np.ones(len(rows), bool)
        while True:
            solved = self.pressed(medium, most)
            end = float(solved.deep[-1])
            deeper = self._depths(rows[:, F], solved) + rise
            here = left & ~((rows[:, F] > 0) & (deeper > end))
            held[here] = self._forces(rows[here], rise[here], solved)
            solutions.append((most, here))
            left &= ~here
            if not left.any():
                return held, solutions
            wanted = float(deeper[left].max())
            most = max(2 * end, wanted) if wanted > LAST * medium.thickness else min(2 * end, LAST * medium.thickness)

    def _depths(self, pushes: Floats, solved: PressedMap) -> Floats:
        """Return the indentations [m] at the path's pushes."""
        return pushes if self.given_depth else np.interp(pushes, solved.force, solved.deep)

    def _forces(self, rows: Floats, rise: Floats | float, solved: PressedMap) -> Floats:
        """Return rows with the forces [N] after a rise of the cover; pulls are unchanged."""
        deep, rows = self._depths(rows[:, F], solved), rows.copy()
        before = np.interp(deep, solved.deep, solved.force) if self.given_depth else rows[:, F].copy()
        pressing = before > 0
        after = np.interp(deep + rise, solved.deep, solved.force)
        rows[:, F] = before
        rows[:, FORCE] *= np.where(pressing, after / np.where(pressing, before, 1), 1)[:, None]
        return rows

    def _spread(
        self, rows: Floats, here: Flags, medium: Medium, depth: float, most: float | None, owner: Integers
    ) -> PatternLoads:
        """Return the loads of these frames, spread by one solution; none in the others."""
        levels = _levels(rows[:, F], self.pressed(medium, most).force[::BETWEEN])
        if not here.all():
            rows = rows.copy()
            rows[~here, FORCE] = 0
        return PatternLoads(self._pattern(medium, depth, most), rows, *levels, owner)

    def pressed(self, medium: Medium, most: float | None = None) -> PressedMap:
        """Return the pressures on the medium up to the path's deepest indentation, or up to ``most`` [m]; cached.

        Raises:
            InputError: as ``rough_contact.RoughContact.pressed``.
        """
        key = replace(medium, quantity="strain"), most
        if key not in self.memory:
            push, by_depth = float(self.path[:, 1 + F].max()), self.given_depth
            if most is not None:
                push, by_depth = most, True
            self.memory[key] = press(self.heights, self.pitch, medium, push, by_depth)
        known: PressedMap = self.memory[key]
        return known

    def _pattern(self, medium: Medium, depth: float, most: float | None) -> LoadPattern:
        """Return the pressures at all levels but the first, which has no force, each as shares of its sum."""
        key = replace(medium, quantity="strain"), most, depth
        if key not in self.memory:
            solved = self.pressed(medium, most)
            shares = solved.forces[1:].copy()
            for level in range(len(shares) - 1, -1, -1):  # without force: those of the next level
                total = shares[level].sum()
                after = shares[level + 1] if level + 1 < len(shares) else np.full(shares.shape[1], 1 / shares.shape[1])
                shares[level] = shares[level] / total if total > 0 else after
            self.memory[key] = LoadPattern(solved.places, shares, depth)
        known: LoadPattern = self.memory[key]
        return known

    def described(self, medium: Medium, depth: float) -> str:
        """Describe the cells of the deepest contact and the uncertainty of its force.

        Raises:
            InputError: as ``pressed``.
        """
        solved = self.pressed(medium)
        return (
            f"contact {solved.width * 1e3:.3g} mm wide on cells of {self.pitch * 1e3:.3g} mm, its force known to about "
            f"{max(solved.doubt, 1e-3):.1%}; solved on cells of {solved.pitch * 1e3:.2g} mm"
        )

    def deepest(self, medium: Medium) -> float:
        """Return the path's largest indentation [m].

        Raises:
            InputError: as ``pressed``.
        """
        most = float(self.path[:, 1 + F].max())
        if self.given_depth or most <= 0:
            return max(most, 0.0)
        solved = self.pressed(medium)
        return float(np.interp(most, solved.force, solved.deep))


def _levels(push: Floats, force: Floats) -> tuple[Integers, Floats]:
    """Return the number of the lower of the two levels around forces (frames,) [N], and both weights (frames, 2).

    Pressures are linear in the force between levels. The first level has force 0 and is not numbered.
    """
    level = np.interp(push, force, np.arange(len(force)))
    low = np.clip(level.astype(np.int64), 0, len(force) - 2)
    part = level - low
    upper = part * force[low + 1]
    whole = (1 - part) * force[low] + upper
    upper = np.where(whole > 0, upper / np.where(whole > 0, whole, 1), 1.0)
    weights = np.stack([1 - upper, upper], axis=-1)
    weights[low == 0] = 1.0, 0.0
    return np.maximum(low - 1, 0), weights
