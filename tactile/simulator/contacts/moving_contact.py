"""Indenters that move over a finger, pressed by force or by depth, with friction or without."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_number
from tactile.core.loads import COLUMNS, PLACE, SHEAR, F, Q
from tactile.elastic.adhesion import AdhesionLaw
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ, Profile
from tactile.simulator.contacts.friction import FrictionState
from tactile.simulator.contacts.friction_history import FrictionHistory, history
from tactile.simulator.contacts.indenter import LAWS, Indenter
from tactile.simulator.contacts.loads import Disc, Loads
from tactile.simulator.contacts.mounting import STILL, Rig, at_a_point
from tactile.simulator.contacts.moving_load import along_path, checked_path, path_array, span
from tactile.simulator.contacts.shapes import LineShape

TORQUE = COLUMNS
"""The column of M, behind those of a load."""


@dataclass(frozen=True, eq=False)  # arrays are not compared
class MovingContact:
    """An indenter on one finger.

    Arguments: ``path`` (n, 7) or, without a twist, (n, 6), rows (t, x, y, Q, R, push, M) [s, m, m, N, N, N or m, N m],
    ``push`` the normal force or, where ``given_depth``, the indentation; M a twist from x to y, which ``friction``
    limits to the sliding torque. Without ``friction`` (None) nothing slips and shear is spread like the pressure.

    Raises:
        InputError: no indenter, a negative friction, a path as of `MovingLoad`.
    """

    finger: int
    indenter: Indenter
    path: Floats
    friction: float | None = None
    given_depth: bool = False

    @spelled()
    def __init__(
        self, finger: int, indenter: Indenter, path: ArrayLike, friction: float | None = None, given_depth: bool = False
    ) -> None:
        given = path_array(path)
        if given.ndim == 2 and given.shape[1] == 1 + COLUMNS:  # without a twist
            given = np.hstack([given, np.zeros((len(given), 1))])
        if not isinstance(indenter, Indenter):
            raise InputError(f"indenter {shown(indenter)} of a contact; an Indenter(shape, ...) wanted")
        if friction is not None and (not is_number(friction) or not friction >= 0):
            raise InputError(f"friction {shown(friction)} of a contact; a number from 0 up wanted")
        for name, value in (("finger", finger), ("indenter", indenter), ("friction", friction)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "given_depth", given_depth)
        object.__setattr__(self, "path", checked_path(given, 2 + COLUMNS, "contact"))

    def __repr__(self) -> str:
        return f"MovingContact(finger={self.finger}, {self.indenter.shape}, {span(self.path)})"

    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        """Return the loads on the finger at the times [s], for taxels at ``depth`` [m], with the indenter in the rig.

        A dry body that is pulled lifts off and carries nothing; a `MovingLoad` is a force, and may pull.

        Raises:
            InputError: an indentation given for a shape without a law for it; a contact too wide for the depth, or
                through the cover.
        """
        if rig.curvature:
            if rig.curvature not in self._on_domes:
                self._on_domes[rig.curvature] = replace(self, indenter=rig.touching(self.indenter))
            return self._on_domes[rig.curvature].loads(times, depth, medium, replace(rig, curvature=0.0))
        if rig.work > 0 and self.indenter.shape in LAWS:
            return self._adhering(times, medium, rig)
        rows = self._at(times, medium)
        if self.indenter.shape == "point":
            rows[rows[:, F] < 0, PLACE.stop :] = 0
            return at_a_point(rows[:, :COLUMNS], medium, rig)
        rows = rig.moved(rows, self.indenter, medium)
        rows[rows[:, F] < 0, PLACE.stop :] = 0
        if isinstance(self.indenter.body, LineShape):
            return self._line(rows, self.indenter.body, depth, medium)
        return self._slipping(times, rows, medium, self._dry_history(medium))

    def friction_at(self, times: Floats, medium: Medium) -> list[FrictionState]:
        """Return the state of friction at the times [s]: the part that sticks, and the force.

        Raises:
            InputError: a contact without friction.
        """
        known = self._dry_history(medium)
        if known is None:
            raise InputError(f"a {self.indenter.shape} without friction; a coefficient wanted")
        return known.at(times, self._at(times, medium))

    def _adhering(self, times: Floats, medium: Medium, rig: Rig) -> Loads:
        from tactile.simulator.contacts.adhesion_path import adhesion_table, attached, moved, with_pull

        body, pushes = self.indenter.round, self.path[:, [0, 1 + F]]
        if (medium, rig.work) not in self._laws:
            self._laws[medium, rig.work] = adhesion_table(body, medium, rig.work, pushes, self.given_depth)
        law = self._laws[medium, rig.work]
        snap = float((law.indentation if self.given_depth else law.force)[0])

        def pull_and_rows(at: Floats) -> tuple[Floats, Floats]:
            rows, gone = along_path(self.path, at)
            rows[gone, PLACE.stop :] = 0
            force, pressed = law.at(rows[:, F], self.given_depth)
            holds = attached(pushes, snap, at)
            rows[~holds, PLACE.stop :] = 0
            rows[:, F] = np.where(holds, pressed, 0)
            return np.where(holds, force - pressed, 0), rows

        pull, rows = pull_and_rows(times)
        if rig.moves:
            pull = moved(rows, pull, partial(adhesion_table, body, medium, rig.work, pushes, self.given_depth), rig)
        slips = self._history_of(medium, rig.work, lambda t: pull_and_rows(t)[1])
        loads = self._slipping(times, rows, medium, slips)
        return with_pull(loads, rows, rows[:, F] + pull, body, medium)

    def _slipping(self, times: Floats, rows: Floats, medium: Medium, slips: FrictionHistory | None) -> Loads:
        if slips is None:
            return self._round(rows, None, medium)
        ends, terms = slips.terms(times, rows)
        rows[:, SHEAR] = terms.sum(axis=1)
        return self._round(rows, (ends, terms), medium)

    def _at(self, times: Floats, medium: Medium) -> Floats:
        """Return rows (x, y, Q, R, F, M) at the times, without force where the contact is absent."""
        rows, gone = along_path(self.path, times)
        rows[gone, PLACE.stop :] = 0
        if self.given_depth:
            rows[rows[:, F] < 0, PLACE.stop : F] = 0  # off the cover
            rows[:, F] = self.indenter.force_at(rows[:, F], medium)
        return rows

    def _dry_history(self, medium: Medium) -> FrictionHistory | None:
        return self._history_of(medium, 0.0, partial(self._at, medium=medium))

    def _history_of(self, medium: Medium, work: float, rows_at: Callable[[Floats], Floats]) -> FrictionHistory | None:
        """Return the history on a medium with a work of adhesion, None without friction."""
        if self.friction is None:
            return None
        if (medium, work) not in self._histories:
            carry = self.indenter.round.carrying(medium)
            self._histories[medium, work] = history(self.path[:, 0], rows_at, self.friction, carry)
        return self._histories[medium, work]

    @cached_property
    def _on_domes(self) -> dict[float, "MovingContact"]:
        return {}

    @cached_property
    def _histories(self) -> dict[tuple[Medium, float], FrictionHistory]:
        return {}

    @cached_property
    def _laws(self) -> dict[tuple[Medium, float], AdhesionLaw]:
        return {}

    def _line(self, rows: Floats, body: LineShape, depth: float, medium: Medium) -> Loads:
        if self.friction is not None:  # an edge slips as a whole
            rows[:, SHEAR] = limited_shear(rows, self.friction)
        total = rows[:, :COLUMNS]
        points = body.points(total, depth, medium)
        return Loads(total[:, None], points, np.zeros(points.shape[1], np.int64))

    def _round(self, rows: Floats, slipped: tuple[Floats, Floats] | None, medium: Medium) -> Loads:
        """Return the loads over circles: the pressure, and the pressures of friction's rings (forces, terms)."""
        body = self.indenter.round
        spread = [rows[:, :COLUMNS]]
        normal_at = [rows[:, F]]
        inner: tuple[Disc, ...] = ()
        if slipped is not None:
            spread[0] = rows[:, :COLUMNS] * (1, 1, 0, 0, 1)
            forces, terms = slipped
            shear = np.zeros((*forces.shape, COLUMNS))
            shear[..., PLACE], shear[..., SHEAR] = rows[:, None, PLACE], terms
            whole = forces >= rows[:, F, None]  # the outermost ring slips under the whole pressure
            stuck = None if whole.all() else body.stuck_circles(rows[:, F, None], forces, medium)
            if stuck is not None:
                circles, pressed, shape = stuck
                spread[0][:, SHEAR] = np.where(whole[..., None], terms, 0).sum(axis=1)
                shear[whole, Q:] = 0
                rest = shear * np.where(np.arange(COLUMNS) < Q, 1, 1 - pressed[..., None])
                inner = (Disc(rest, circles, shape, medium.thickness, np.zeros(shear.shape[1], np.int64)),)
                shear[..., SHEAR] *= pressed[..., None]
            spread += list(np.moveaxis(shear, 1, 0))
            normal_at += list(forces.T)
        discs, forces = np.stack(spread, axis=1), np.stack(normal_at, axis=1)
        radii = body.contact_radius(forces, medium)
        if inner:
            radii[:, 1:] = inner[0].radii
        profile, unit = body.profile(medium)
        owner = np.zeros(discs.shape[1], np.int64)
        twists: tuple[Disc, ...] = ()
        if rows[:, TORQUE].any():
            torque = rows[:, TORQUE]
            if self.friction is not None:  # the sliding torque: friction under the pressure
                lever = profile.mean_radius(radii[:, 0] / unit) * radii[:, 0]
                limit = self.friction * np.maximum(rows[:, F], 0) * lever
                torque = np.clip(torque, -limit, limit)
            turned = np.zeros((len(rows), 1, COLUMNS + 1))
            turned[:, 0, PLACE], turned[:, 0, TORQUE] = rows[:, PLACE], torque
            twists = (Disc(turned, radii[:, :1], *_twist_profile(radii[:, :1], medium), owner[:1]),)
        points = np.empty((len(rows), 0, COLUMNS))
        return Loads(
            rows[:, None, :COLUMNS], points, owner[:0], (Disc(discs, radii, profile, unit, owner), *inner), twists
        )


def limited_shear(rows: Floats, friction: float) -> Floats:
    """Return the shear (frames, 2) [N] of loads (frames, 5 or more), at most the friction times the normal force."""
    pull, most = np.hypot(*rows[:, SHEAR].T), friction * np.maximum(rows[:, F], 0)
    factor = np.where(pull > most, most / np.where(pull > 0, pull, 1), 1)
    return np.asarray(rows[:, SHEAR] * factor[:, None])


def _twist_profile(radii: Floats, medium: Medium) -> tuple[Profile, float]:
    """Return the pressure whose slope is a twist's traction, and the length [m] by which radii become its lam."""
    if np.isinf(medium.thickness):
        return HERTZ, np.inf
    from tactile.elastic.layer_contact import WIDEST  # imports SciPy's splines
    from tactile.elastic.layer_twist import layer_twist

    if (radii > WIDEST * medium.thickness).any():
        raise InputError(
            f"a twisted contact {radii.max() * 1e3:.4g} mm in radius on a cover of {medium.thickness * 1e3:g} mm; at "
            f"most {WIDEST:g} thicknesses wanted"
        )
    return layer_twist(), medium.thickness
