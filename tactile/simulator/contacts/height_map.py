"""Bodies of any shape, given as a height map, that move over a finger and press by force or by depth."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, FORCE, PLACE, SHEAR, F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import along_path, checked_path, span
from tactile.simulator.contacts.rig import STILL, Rig

LEVELS = 17
"""Indentations at which pressures are solved, closer where the contact begins; in between they are straight."""


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
        deep, force, places, pressures = self._solved(medium)
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
            cell[:] = np.interp(rows[:, F], force, column)
        total = share.sum(axis=1, keepdims=True)
        share = np.where(total > 0, share / np.where(total > 0, total, 1), 1 / len(places))
        points = np.empty((len(rows), len(places), COLUMNS))
        points[..., PLACE] = rows[:, None, PLACE] + places
        points[..., FORCE] = rows[:, None, FORCE] * share[..., None]
        return Loads(rows[:, None], points, np.zeros(len(places), np.int64))

    def _solved(self, medium: Medium) -> tuple[Floats, Floats, Floats, Floats]:
        """Indentations (levels,), forces (levels,), cells that are pressed (n, 2) and their forces (levels, n)."""
        key = replace(medium, quantity="strain")
        if key not in self.memory:
            self.memory[key] = self._solve(medium)
        solved: tuple[Floats, Floats, Floats, Floats] = self.memory[key]
        return solved

    def _solve(self, medium: Medium) -> tuple[Floats, Floats, Floats, Floats]:
        from tactile.elastic.rough_contact import RoughContact  # only where called for

        contact, most = RoughContact(self.heights, self.pitch, medium), float(self.path[:, 1 + F].max())
        deepest = max(most, 1e-9) * 1.05 if self.given_depth else self._depth_of(contact, max(most, 1e-12))
        deep = deepest * np.linspace(0, 1, LEVELS) ** 2
        levels: list[Floats] = []
        last: Floats | None = None
        for one in deep.tolist():
            last = contact.pressed(one, last)
            levels.append(last)
        forces = np.stack(levels) * self.pitch**2
        pressed = forces.any(axis=0)
        if not pressed.any():
            pressed.flat[int(self.heights.argmin())] = True
        rows, cols = self.heights.shape
        y, x = np.nonzero(pressed)
        places = np.stack([x - (cols - 1) / 2, y - (rows - 1) / 2], axis=-1) * self.pitch
        return deep, forces.sum(axis=(1, 2)), places, forces[:, pressed]

    def _depth_of(self, contact: Any, force: float) -> float:
        """An indentation that takes a little more than this force."""
        deep = self.pitch / 100
        while float(contact.pressed(deep).sum()) * self.pitch**2 < 1.02 * force:
            deep *= 1.5
        return deep
