"""Readings under contacts that a rig holds at a height, when the surface rises."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.compiled_loops import kept_njit
from tactile.core.loads import F
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.mounting import Rises
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.field import Contact, Field


def raised(field: Field, rises: Rises, before: Rises = ()) -> float:
    """The largest change of a field's readings when the surface, raised ``before``, rises still more under contacts.

    Readings grow with the forces, at most like the one that grows most: the lighter a contact, the more it does.
    """
    if not any(rise for rise, _ in rises):
        return 0.0
    if _by_tips(field):  # at one go
        more, least = _lift(field.medium, rises), _lift(field.medium, before)
        return float(_raised_points(*pushes(field), least, least + more))
    if field.medium.thickness < math.inf and all(map(is_point, field.contacts)):  # the same on a layer
        from tactile.simulator.contacts.tip_law import most_raised  # only where called for

        forces, _, readings = pushes(field)
        return most_raised(forces, readings, before, rises, field.medium)
    values = np.ascontiguousarray(field.values).reshape(len(field.times), -1)
    growth = np.abs(_growth(field, (*before, *rises)) - _growth(field, before)).max(axis=1, initial=0)
    return float((growth * np.abs(values).max(axis=1, initial=0)).max(initial=0))


def grown(field: Field, rises: Rises) -> Floats:
    """By what the force of the contact that grows most does in every frame (frames,) when the surface rises."""
    if not _by_tips(field):
        return np.asarray(_growth(field, rises).max(axis=1, initial=1.0))
    deep = np.maximum(field.loads.totals[..., F], 0.0) ** (2 / 3)
    growth = np.divide(deep + _lift(field.medium, rises), deep, out=np.ones_like(deep), where=deep > 0)
    return np.asarray(growth.max(axis=1, initial=1.0) ** 1.5)


def lifted(field: Field, rises: Rises) -> Field:
    """The field whose contacts the surface has risen under."""
    rig = field.rig
    for rise, tip in rises:
        rig = rig.with_move(partial(_everywhere, rise), tip)
    return replace(field, rig=rig)


def pressed_by(force: float, medium: Medium, rises: Rises) -> float:
    """The normal force [N] of a contact at a point, held by its tip, when the surface rises."""
    if medium.thickness < math.inf:
        from tactile.simulator.contacts.tip_law import most_pressed  # only where called for

        return most_pressed(force, rises, medium)
    return float((max(force, 0.0) ** (2 / 3) + _lift(medium, rises)) ** 1.5)


def is_point(contact: Contact) -> bool:
    """Whether what presses does so at one point, which a tip holds: a force, whatever the cover."""
    if isinstance(contact, MovingContact):
        return contact.indenter.shape == "point"
    return isinstance(contact, MovingLoad | SlidingTexture)


def _by_tips(field: Field) -> bool:
    """Whether all forces follow the half-space's law of a tip, which adds what rises do."""
    return field.at_points and field.medium.thickness == math.inf


def _lift(medium: Medium, rises: Rises) -> float:
    """What rises add to F^(2/3) under tips, F = 4 / 3 E* sqrt(R) delta^1.5."""
    lift = 0.0
    for rise, tip in rises:
        lift += (4 / 3 * medium.contact_modulus * tip**0.5) ** (2 / 3) * rise
    return lift


def _growth(field: Field, rises: Rises) -> Floats:
    """By what every contact's force grows (frames, contacts)."""
    forces = field.loads.totals[..., F]
    if not rises:
        return np.ones_like(forces)
    pressed = lifted(field, rises).loads.totals[..., F]
    return np.where(forces != 0, pressed / np.where(forces != 0, forces, 1), 1.0)


def _everywhere(rise: float, places: Floats) -> tuple[Floats, Floats]:
    return np.zeros_like(places), np.full(len(places), rise)


def pushes(field: Field) -> tuple[Floats, Floats, Floats]:
    """Forces of points and their 2/3rd power (frames, n), and the largest reading (frames,): kept with the field."""
    kept: tuple[Floats, Floats, Floats] | None = field.__dict__.get("_pushes")
    if kept is None:
        values = np.ascontiguousarray(field.values).reshape(len(field.times), -1)
        kept = field.__dict__["_pushes"] = _pressed_points(field.loads.totals, values)
    return kept


@kept_njit()
def _pressed_points(rows, values):  # type: ignore[no-untyped-def]  # numba types it at the call
    """The same of rows (frames, n, 5) and readings (frames, channels); what does not press has no force."""
    frames, count = rows.shape[:2]
    forces, deep, readings = np.zeros((frames, count)), np.zeros((frames, count)), np.zeros(frames)
    for n in range(frames):
        for m in range(count):
            if rows[n, m, F] > 0:
                forces[n, m], deep[n, m] = rows[n, m, F], rows[n, m, F] ** (2 / 3)
        for c in range(values.shape[1]):
            readings[n] = max(readings[n], abs(values[n, c]))
    return forces, deep, readings


@kept_njit()
def _raised_points(forces, deep, readings, least, most):  # type: ignore[no-untyped-def]  # the same
    """The largest change of readings between two lifts."""
    out = 0.0
    for n in range(forces.shape[0]):
        growth = 0.0
        for m in range(forces.shape[1]):
            force = forces[n, m]
            if force > 0:
                high, low = deep[n, m] + most, deep[n, m] + least
                before = force if least == 0 else low * math.sqrt(low)
                growth = max(growth, (high * math.sqrt(high) - before) / force)
        out = max(out, growth * readings[n])
    return out
