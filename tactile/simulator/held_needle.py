"""Force of a needle that a rig holds at a height, when needle or surface move."""

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_indentation


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
