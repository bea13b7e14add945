"""What a bonded layer adds to the half-space under loads and twists spread over circles, one by one by quadrature.

For circles so wide, and accuracies so fine, that a table would take as long as thousands of these.
"""

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, PLACE, F, Q, R
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile
from tactile.elastic.unit_disc import EVEN, ODD, RZ, TWIST, ZR, ZZ, layer

TORQUE = COLUMNS


def add_layer(
    out: Floats, positions: Floats, depth: float, loads: Floats, radii: Floats, profile: Profile, unit: float,
    medium: Medium,
) -> None:  # fmt: skip
    """Add to ``out`` (frames, taxels, 3).

    Arguments: ``positions`` (taxels, 2) [m]; ``loads`` (frames, n, 5 or 6) and ``radii`` (frames, n) [m] as
    ``disc_loops.add_discs``; ``unit`` [m]: the profile's lam is the radius over it; ``medium`` with a thickness.

    Source: ``unit_disc``, to some 1e-10 of the peak.
    """
    ratio = depth / medium.thickness
    scale = 1 / depth**2 if medium.quantity == "stress" else 1 / (medium.modulus * depth**2)
    for n, m in np.argwhere((loads[..., PLACE.stop :] != 0).any(axis=-1)).tolist():
        load, radius = loads[n, m], radii[n, m : m + 1]
        x, y = (positions - load[PLACE]).T / depth
        rho = np.hypot(x, y)
        felt = layer(rho * ratio, radius / medium.thickness, profile, radius / unit, medium, ratio)[0] * ratio**2
        q, r, f = (scale * load[[Q, R, F]]).tolist()
        turn = scale / depth * float(load[TORQUE]) if len(load) > TORQUE else 0.0
        far = np.where(rho > 0, rho, 1.0)
        c, s = np.where(rho > 0, x, 1.0) / far, y / far
        along, twisted = q * c + r * s, turn * ratio * felt[:, TWIST]
        out[n, :, 0] += q * felt[:, EVEN] - (2 * c * along - q) * felt[:, ODD] + s * twisted - c * f * felt[:, RZ]
        out[n, :, 1] += r * felt[:, EVEN] - (2 * s * along - r) * felt[:, ODD] - c * twisted - s * f * felt[:, RZ]
        out[n, :, 2] += f * felt[:, ZZ] - along * felt[:, ZR]
