"""A circle that sticks to a bonded layer and is turned: its traction by an energy method, and the strains under it.

Thickness and shear modulus are 1. The traction is a sum of r P_n(r^2) / sqrt(a^2 - r^2), whose transforms are spherical
Bessel functions; its energy is least for the given turn. No integral equation, no line weights.
"""

import numpy as np
from scipy.special import j1, spherical_jn

from cnnsim.support import Floats


def turned(radius: float, rho: Floats, depth: float, terms: int = 24) -> Floats:
    """Strain u_theta_z (n,) at distances ``rho`` and a depth under a torque of 1."""
    nodes, weights = np.polynomial.legendre.leggauss(2000)
    top = 40 / min(depth, 1.0)
    k, step = (nodes + 1) * top / 2, weights * top / 2
    waves = np.array([spherical_jn(2 * n + 1, k * radius) for n in range(terms)])
    stiff = np.diag(np.pi / (2 * (4 * np.arange(terms) + 3) * radius)) - (waves * (step * (1 - np.tanh(k)))) @ waves.T
    share = np.linalg.solve(stiff, np.eye(terms)[0])
    traction = share @ waves / (share[0] * radius / 3 * 4 * np.pi)  # torque: 4 pi times its slope at k = 0
    down = np.exp(-k * depth) * (1 + np.exp(-2 * k * (1 - depth))) / (1 + np.exp(-2 * k))
    out: Floats = -j1(np.outer(rho, k)) @ (traction * down * k * step) / 2
    return out
