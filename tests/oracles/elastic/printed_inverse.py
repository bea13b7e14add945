"""The inverse of a strain taxel as the paper prints it, term by term: the reference for the stable form."""

from typing import Any

import numpy as np


def printed_inverse(shear: Any, normal: Any, dtype: Any) -> tuple[Any, Any]:
    """Return rho / z, and F over 4 pi E z^2 / 3, of signals |(u_xz, u_yz)| and u_zz of a load that presses.

    Source: Vasarhelyi, Fodor, Roska, eqs (3), (5) with the 3 outside the root, (6), (8).
    """
    a, b = (np.asarray(part, dtype) for part in (shear, normal))
    with np.errstate(all="ignore"):
        root = np.sqrt(dtype(9) + dtype(8) * (a * a / (b * b)))
        inside = dtype(2) - dtype(12) / (root + dtype(3))
        outside = dtype(2) + dtype(12) / (root - dtype(3))
        t = np.where(b < 0, inside, outside)
        power = (t + dtype(1)) ** dtype(2.5)
        return np.sqrt(t), b * power / (t - dtype(2))
