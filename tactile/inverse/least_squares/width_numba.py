"""How far a load may be off because it is not a point but wide, compiled, to first order in its area.

A wide tip, and any load on a cover that spreads it otherwise than is thought, changes the signals by the mean square
radius times the curvature of a point load's. What of that the load has taken for its own is not seen; the part that is
seen says how much it was. Lengths and signals as in `half_space_numba`.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.least_squares.equations_numba import equations, rest
from tactile.inverse.least_squares.fit_numba import back

RADIUS = 0.5
"""The ring [depths] that stands for a width: its mean square radius is that of a ball's contact of 0.8 depths."""
AROUND = 4
"""Places on it: what it adds has the curvature of a circle up to the third power of the radius."""


@kept_njit(error_model="numpy")
def width(at, felt, scale, load, strain, layer, tie, factor, moved):  # type: ignore[no-untyped-def]  # numba types it
    """Fill ``moved`` (5,): how far each number of the load is off for the ring's width; return g' r and g' g'.

    With g what the ring adds to the signals, J the slopes, C = (J J^T)^-1, and g' = g - J^T C J g what of it is seen,
    of the rest r the part a = g' r / g' g' is a width, by which the load is off by -a C J g. ``factor``: of J J^T.
    """
    work, nothing = np.empty((2 * AROUND + 5, 5)), np.zeros((len(at), 3))
    ring, one, matrix, vector = work[: AROUND + 1], work[AROUND + 1 : AROUND + 2], work[AROUND + 3 :], work[AROUND + 2]
    for m in range(5):
        one[0, m] = load[m]
        for k in range(AROUND + 1):
            ring[k, m] = load[m] / AROUND if m > 1 else load[m]
        ring[AROUND, m] = -load[m] if m > 1 else load[m]
    for k in range(AROUND):
        ring[k, 0] += RADIUS * math.cos(2 * math.pi * k / AROUND)
        ring[k, 1] += RADIUS * math.sin(2 * math.pi * k / AROUND)
    added = rest(at, nothing, scale, ring, strain, layer)  # -g
    left = rest(at, felt, scale, one, strain, layer)
    along = 0.0
    for i in range(len(at)):
        for k in range(3):
            along -= added[i, k] * left[i, k]
            left[i, k] = felt[i, k] - left[i, k] + added[i, k]  # of which the load leaves -g
    seen = equations(at, left, scale, one, strain, layer, matrix, vector)
    back(factor, vector, moved)
    for m in range(5):
        seen -= vector[m] * moved[m]
    return along, seen
