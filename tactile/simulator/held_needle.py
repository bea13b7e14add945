"""Readings under contacts that a rig holds at a height, when the surface rises."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.core.loads import F
from tactile.simulator.field import Field


def raised(field: Field, rise: float, needle: float) -> float:
    """The largest change of a field's readings when the surface rises by ``rise`` [m] under all contacts.

    Readings grow with the forces, at most like the one that grows most; contacts at a point are tips of radius
    ``needle`` [m].
    """

    def move(places: Floats) -> tuple[Floats, Floats]:
        return np.zeros_like(places), np.full(len(places), rise)

    if rise == 0:
        return 0.0
    values = np.ascontiguousarray(field.values).reshape(len(field.times), -1)
    if field.at_points:  # all by the law of the tip, F = 4 / 3 E* sqrt(R) delta^1.5, at one go
        stiff = 4 / 3 * field.medium.contact_modulus * needle**0.5
        return float(_raised_points(field.loads.totals, values, stiff, rise))
    forces = field.loads.totals[..., F]
    pressed = replace(field, rig=field.rig.with_move(move, needle)).loads.totals[..., F]
    factor = np.where(forces != 0, pressed / np.where(forces != 0, forces, 1), 1.0)
    readings = np.abs(values).max(axis=1, initial=0)
    return float((np.abs(factor - 1).max(axis=1, initial=0) * readings).max(initial=0))


@kept_njit()
def _raised_points(rows, values, stiff, rise):  # type: ignore[no-untyped-def]  # numba types it at the call
    """The same of points, rows (frames, n, 5) and readings (frames, channels) of theirs."""
    out = 0.0
    for n in range(rows.shape[0]):
        grown = 0.0
        for m in range(rows.shape[1]):
            if rows[n, m, F] > 0:
                grown = max(grown, (1 + rise / (rows[n, m, F] / stiff) ** (2 / 3)) ** 1.5 - 1)
        most = 0.0
        for c in range(values.shape[1]):
            most = max(most, abs(values[n, c]))
        out = max(out, grown * most)
    return out
