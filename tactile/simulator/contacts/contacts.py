"""Contacts on a finger over time: point loads and indenters, pressed by force or by depth, with friction or without."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cnnsim.support.types import Floats
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.friction import Slip, load_to, untouched
from tactile.simulator.contacts.indenter import ROUND, Indenter
from tactile.simulator.contacts.loads import Disc, Pressed, Twist, point_loads


def along_path(path: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """The path's columns (n, columns - 1) at the times [s], and where it is not there.

    Between its rows a path changes linearly; before the first and after the last it is not there. With one row it
    stands still from that time on.
    """
    rows = np.stack([np.interp(times, path[:, 0], column) for column in path[:, 1:].T], axis=-1)
    gone = times < path[0, 0]
    if len(path) > 1:
        gone |= times > path[-1, 0]
    return rows, gone


@dataclass(frozen=True)
class MovingLoad:
    """A point load on one finger: ``path`` (n, 6), rows (t, x, y, Q, R, F) [s, m, m, N, N, N], t growing."""

    finger: int
    path: Floats

    def at(self, times: Floats) -> Floats:
        """Return rows (x, y, Q, R, F) [m, N] at the times [s], without force where the load is absent."""
        rows, gone = along_path(self.path, times)
        rows[gone, 2:] = 0
        return rows

    def pressed(self, times: Floats, depth: float, medium: Medium) -> Pressed:
        """What presses on the finger at the times [s]."""
        return point_loads(self.at(times))


@dataclass(frozen=True)
class MovingContact:
    """An indenter on one finger.

    Arguments: ``path`` (n, 7), rows (t, x, y, Q, R, push, M) [s, m, m, N, N, N or m, N m], ``push`` the normal force
    or, where ``given_depth``, the indentation; M a twist from x to y, which ``friction`` limits to the sliding
    torque. Without ``friction`` (None) nothing slips and shear is spread like the pressure.
    """

    finger: int
    indenter: Indenter
    path: Floats
    friction: float | None = None
    given_depth: bool = False

    def pressed(self, times: Floats, depth: float, medium: Medium) -> Pressed:
        """What presses on the finger at the times [s], for taxels at ``depth`` [m].

        Raises:
            InputError: an indentation given for a shape that knows no law for it; a contact too wide for the depth.
        """
        rows, gone = along_path(self.path, times)
        rows[gone, 2:] = 0
        rows = self._forces(rows, medium)
        if self.indenter.shape not in ROUND:
            return self._line(rows, depth, medium)
        slips = self._slips(times, rows, medium) if self.friction is not None else None
        if slips is not None:
            rows[:, 2:4] = [slip.force if slip.ends.size else (0, 0) for slip in slips]
        return self._round(rows, slips, medium)

    def slip_at(self, times: Floats, medium: Medium) -> list[Slip]:
        """The state of friction at the times [s]: what sticks, what the contact carries.

        Raises:
            InputError: a contact without friction.
        """
        rows, gone = along_path(self.path, times)
        rows[gone, 2:] = 0
        return self._slips(times, self._forces(rows, medium), medium)

    def _forces(self, rows: Floats, medium: Medium) -> Floats:
        rows = rows.copy()
        if self.given_depth:
            rows[:, 4] = self.indenter.force_at(rows[:, 4], medium)
        return rows

    def _slips(self, times: Floats, rows: Floats, medium: Medium) -> list[Slip]:
        at_keys = self._histories(medium)
        # the state at the last keyframe before, then one step: a straight way of loading needs no more
        last = np.searchsorted(self.path[:, 0], times, side="right")
        return [load_to(at_keys[k], row[4], row[2:4]) for k, row in zip(last.tolist(), rows, strict=True)]

    def _histories(self, medium: Medium) -> list[Slip]:
        known = self._history.get(medium)
        if known is None:
            known = [untouched(self.friction or 0.0)]
            for row in self._forces(self.path[:, 1:], medium):
                known.append(load_to(known[-1], row[4], row[2:4]))
            self._history[medium] = known
        return known

    @cached_property
    def _history(self) -> dict[Medium, list[Slip]]:
        return {}

    def _line(self, rows: Floats, depth: float, medium: Medium) -> Pressed:
        if self.friction is not None:  # all of an edge slips at once
            tangential = np.hypot(rows[:, 2], rows[:, 3])
            most = self.friction * np.maximum(rows[:, 4], 0)
            rows[:, 2:4] *= np.where(tangential > most, most / np.where(tangential > 0, tangential, 1), 1)[:, None]
        total, shape = rows[:, :5], self.indenter
        if shape.shape == "point":
            return point_loads(total)
        from tactile.elastic.lines import cylinder_half_width, cylinder_loads, edge_loads  # only where called for

        if shape.shape == "edge":
            loads = edge_loads(total, shape.length, shape.angle, depth)
        else:
            width = cylinder_half_width(total[:, 4], shape.length, shape.radius, medium.contact_modulus)
            loads = cylinder_loads(total, shape.length, width, shape.angle, depth)
        return Pressed(total[:, None], loads, np.zeros(loads.shape[1], np.int64))

    def _round(self, rows: Floats, slips: list[Slip] | None, medium: Medium) -> Pressed:
        spread = [rows[:, :5]]
        normal_at = [rows[:, 4]]
        if slips is not None:
            spread[0] = rows[:, :5] * (1, 1, 0, 0, 1)
            most = max((slip.ends.size for slip in slips), default=0)
            shear, forces = np.zeros((len(rows), most, 5)), np.zeros((len(rows), most))
            shear[..., :2] = rows[:, None, :2]
            for n, slip in enumerate(slips):
                if slip.ends.size:
                    forces[n, : slip.ends.size], shear[n, : slip.ends.size, 2:4] = slip.terms()
            spread += list(np.moveaxis(shear, 1, 0))
            normal_at += list(forces.T)
        loads, forces = np.stack(spread, axis=1), np.stack(normal_at, axis=1)
        radii = self.indenter.contact_radius(forces, medium)
        profile = ROUND[self.indenter.shape]
        lam = np.minimum(radii / self.indenter.radius, 1.0) if self.indenter.shape == "needle" else np.zeros_like(radii)
        owner = np.zeros(loads.shape[1], np.int64)
        twists: tuple[Twist, ...] = ()
        if rows[:, 5].any():
            torque = rows[:, 5]
            if self.friction is not None:  # sliding torque of Hertz' pressure
                limit = 3 * np.pi / 16 * self.friction * np.maximum(rows[:, 4], 0) * radii[:, 0]
                torque = np.clip(torque, -limit, limit)
            turned = np.stack([rows[:, 0], rows[:, 1], torque], axis=-1)
            twists = (Twist(turned[:, None], radii[:, :1], np.zeros(1, np.int64)),)
        totals = rows[:, None, :5]
        return Pressed(
            totals, np.empty((len(rows), 0, 5)), owner[:0], (Disc(loads, radii, lam, profile, owner),), twists
        )
