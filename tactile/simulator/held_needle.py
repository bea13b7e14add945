"""Force of a needle that a rig holds at a height, when needle or surface move."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import F
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_indentation
from tactile.simulator.field import Field


def force_factor(forces: Floats, rise: Floats, tip_radius: float, medium: Medium) -> Floats:
    """By what the force of a held spherical tip grows when the surface rises by ``rise`` [m] against it.

    Force goes with indentation^1.5, so the factor is max(1 + rise / delta, 0)^1.5 with delta the indentation under the
    undisturbed force. What does not press (force 0 or pulling) stays as it is.

    Source: Johnson, Contact Mechanics, eq. (4.23).
    """
    depth = hertz_indentation(forces, tip_radius, medium.contact_modulus)
    pressing = depth > 0
    ratio = rise / np.where(pressing, depth, 1.0)
    factor: Floats = np.where(pressing, np.maximum(1 + ratio, 0) ** 1.5, 1.0)
    return factor


def raised(field: Field, rise: float, tip_radius: float) -> float:
    """The largest change of a field's readings when the surface rises by ``rise`` [m] under all contacts.

    Readings grow with the forces, at most like the one that grows most.
    """
    forces = field.loads.totals[..., F]
    factor = force_factor(forces, np.full_like(forces, rise), tip_radius, field.medium)
    readings = np.abs(field.values).reshape(len(forces), -1).max(axis=1, initial=0)
    return float((np.abs(factor - 1).max(axis=1, initial=0) * readings).max(initial=0))
