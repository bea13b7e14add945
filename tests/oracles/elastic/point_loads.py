"""Displacements under point loads on a half-space, for bodies cut out of it: an oracle of elements in (r, theta, z)."""

import numpy as np

from cnnsim.support import Floats


def boussinesq(r: Floats, z: Floats, nu: float) -> Floats:
    """(u_r, u_z) under F = 4 pi G. Source: Johnson, Contact Mechanics, eq. (3.18)."""
    far = np.hypot(r, z)
    return np.stack([r * z / far**3 - (1 - 2 * nu) * r / (far * (far + z)), z**2 / far**3 + 2 * (1 - nu) / far])


def cerruti(r: Floats, z: Floats, nu: float) -> Floats:
    """(U + V, U - V, W) under Q = 4 pi G along x. Source: Johnson, Contact Mechanics, eq. (3.75)."""
    far, loose = np.hypot(r, z), 1 - 2 * nu
    along = 1 / far + r**2 / far**3 + loose * (1 / (far + z) - r**2 / (far * (far + z) ** 2))  # u_x at theta = 0
    across = 1 / far + loose / (far + z)  # u_x at theta = 90 degrees, there -u_theta
    down = r * z / far**3 + loose * r / (far * (far + z))
    return np.stack([along - across, along + across, down])
