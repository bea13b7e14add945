"""Bodies of any shape, given as a height map, that move over a finger and press by force or by depth."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, FORCE, PLACE, SHEAR, F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.fewer_points import fewer_points
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import along_path, checked_path, span
from tactile.simulator.contacts.pressed_map import BETWEEN, PressedMap, press
from tactile.simulator.contacts.rig import STILL, Rig


@dataclass(frozen=True, eq=False, repr=False)  # arrays are not compared
class HeightMap:
    """A rigid body with an underside of ``heights`` (rows, cols) [m], cells of a ``pitch`` [m].

    ``path`` (n, 6) rows (t, x, y, Q, R, push) [s, m, m, N, N, N or m] of the map's middle, ``push`` the normal force
    or, where ``given_depth``, the indentation of its lowest point. Shear is spread like the pressure; with ``friction``
    all of it slips at once. A body that is pulled has lifted off.
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
        """The loads on the finger at the times [s], for taxels at ``depth`` [m], as the rig holds the body.

        Raises:
            InputError: cells wider than half the depth; as ``rough_contact.RoughContact.pressed``.
        """
        if self.pitch > depth / 2 * (1 + 1e-9):
            raise InputError(
                f"a height map of cells {self.pitch * 1e3:g} mm wide over taxels {depth * 1e3:g} mm deep; at most half"
                " the depth wanted"
            )
        rows, gone = along_path(self.path, times)
        rows[gone, PLACE.stop :] = 0
        solved = self.pressed(medium)
        deep, force = solved.deep, solved.force
        places, pressures = self._felt(medium, depth)
        if self.given_depth:
            rows[rows[:, F] < 0, SHEAR] = 0
            rows[:, F] = np.interp(rows[:, F], deep, force)
        for move, _ in rig.moves:
            shift, rise = move(rows[:, PLACE])
            rows[:, PLACE] += shift
            moved = np.interp(np.interp(rows[:, F], force, deep) + rise, deep, force)
            pressing = rows[:, F] > 0
            rows[:, FORCE] *= np.where(pressing, moved / np.where(pressing, rows[:, F], 1), 1)[:, None]
        rows[rows[:, F] < 0, PLACE.stop :] = 0
        if self.friction is not None:
            pull, most = np.hypot(*rows[:, SHEAR].T), self.friction * rows[:, F]
            rows[:, SHEAR] *= np.where(pull > most, most / np.where(pull > 0, pull, 1), 1)[:, None]
        share = np.empty((len(rows), len(places)))
        for cell, column in zip(share.T, pressures.T, strict=True):
            cell[:] = np.interp(rows[:, F], force[::BETWEEN], column)
        total = share.sum(axis=1, keepdims=True)
        share = np.where(total > 0, share / np.where(total > 0, total, 1), 1 / len(places))
        points = np.empty((len(rows), len(places), COLUMNS))
        points[..., PLACE] = rows[:, None, PLACE] + places
        points[..., FORCE] = rows[:, None, FORCE] * share[..., None]
        return Loads(rows[:, None], points, np.zeros(len(places), np.int64))

    def pressed(self, medium: Medium) -> PressedMap:
        """How it presses on the medium: pressures up to the deepest that its path asks for, solved once.

        Raises:
            InputError: as ``rough_contact.RoughContact.pressed``.
        """
        key = replace(medium, quantity="strain")
        if key not in self.memory:
            most = float(self.path[:, 1 + F].max())
            self.memory[key] = press(self.heights, self.pitch, medium, most, self.given_depth)
        known: PressedMap = self.memory[key]
        return known

    def _felt(self, medium: Medium, depth: float) -> tuple[Floats, Floats]:
        """Places (n, 2) and forces (levels, n) that taxels at a depth [m] cannot tell from those of all cells."""
        key = replace(medium, quantity="strain"), depth
        if key not in self.memory:
            solved = self.pressed(medium)
            self.memory[key] = fewer_points(solved.places, solved.forces, depth, medium)
        known: tuple[Floats, Floats] = self.memory[key]
        return known

    def described(self, medium: Medium, depth: float) -> str:
        """On what cells its deepest contact is given and solved, how well its force is known, and of how many loads.

        Raises:
            InputError: as ``pressed``.
        """
        solved = self.pressed(medium)
        return (
            f"contact {solved.width * 1e3:.3g} mm wide on cells of {self.pitch * 1e3:.3g} mm, its force known to about "
            f"{max(solved.doubt, 1e-3):.1%}; solved on cells of {solved.pitch * 1e3:.2g} mm, felt as "
            f"{len(self._felt(medium, depth)[0])} loads"
        )

    def deepest(self, medium: Medium) -> float:
        """The largest indentation [m] that its path asks for.

        Raises:
            InputError: as ``pressed``.
        """
        most = float(self.path[:, 1 + F].max())
        if self.given_depth or most <= 0:
            return max(most, 0.0)
        solved = self.pressed(medium)
        return float(np.interp(most, solved.force, solved.deep))
