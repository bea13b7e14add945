"""Load of a force array: sum of forces, centre of pressure, torque about it."""

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity


def summed(positions: Floats, values: Floats, valid: Flags, floor: float) -> Load:
    """Return the sum of the forces of all taxels as one load.

        F = sum n_i,  (x, y) = sum n_i (x_i, y_i) / F over the taxels that are pressed,  Q, R = sums of the shear
        M = sum (x_i - x) R_i - (y_i - y) Q_i, positive from x to y: clockwise as seen in the picture

    Arguments: ``positions`` (rows, cols, 2) [m]; ``values`` (rows, cols, 3) [N]; ``valid`` (rows, cols); ``floor`` [N]:
    a total below it is no load, and taxels below it do not count for the place.
    """
    from tactile.inverse.summed_numba import sums  # numba is slow to import

    x, y, q, r, f, torque, pressed, read = sums(np.asarray(positions), values, valid, floor)
    if not read:
        return Load(validity=Validity.INVALID)
    if not pressed:
        return Load(Q=q, R=r, F=f, validity=Validity.NO_LOAD)
    return Load(x, y, q, r, f, taxels=pressed, validity=Validity.INSIDE, torque=torque)
