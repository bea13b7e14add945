"""Readings under contacts that a rig holds at a height, when the surface rises."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import F
from tactile.simulator.contacts.rig import POINT
from tactile.simulator.field import Field


def raised(field: Field, rise: float, needle: float) -> float:
    """The largest change of a field's readings when the surface rises by ``rise`` [m] under all contacts.

    Readings grow with the forces, at most like the one that grows most; contacts at a point are tips of radius
    ``needle`` [m].
    """

    def move(places: Floats) -> tuple[Floats, Floats]:
        return np.zeros_like(places), np.full(len(places), rise)

    forces = field.loads.totals[..., F]
    if rise == 0:
        return 0.0
    if field.at_points:  # all by the law of the tip, at one go
        factor = POINT.held_factor(forces, np.full(forces.shape, rise), field.medium, needle)
    else:
        pressed = replace(field, rig=field.rig.with_move(move, needle)).loads.totals[..., F]
        factor = np.where(forces != 0, pressed / np.where(forces != 0, forces, 1), 1.0)
    readings = np.abs(field.values).reshape(len(forces), -1).max(axis=1, initial=0)
    return float((np.abs(factor - 1).max(axis=1, initial=0) * readings).max(initial=0))
