"""One point load at one go, from the readings of a frame or the taxels' answers, where nothing is in doubt.

Where something is, `tactile.inverse.localise` goes its long way, which would say the same of what is told here.
"""

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.layer_field import layer_field
from tactile.inverse.alternatives import BESIDE, HINTED, TWO
from tactile.inverse.attempt import DOUBT, RIVAL, SEEDS, UNSURE, VOTERS
from tactile.inverse.clipped import ALIKE, HINT, NEAR_END, TOLD
from tactile.inverse.least_squares.fit import (
    ALL,
    CHANCE,
    FOREIGN,
    LEAST_FREE,
    MANY,
    REACH,
    SLIGHT,
    SMALL,
    STEPS,
    SURELY,
    SURELY_NONE,
    USUAL,
)
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights

FEWEST = 4
"""Fewer taxels are never without doubt."""
OF_ATTEMPT = VOTERS, SEEDS, STEPS, REACH
OF_FIT = FOREIGN[0], SURELY, *FOREIGN[1:], CHANCE, SURELY_NONE, SMALL, USUAL, MANY
LIMITS = FEWEST, ALL, RIVAL, UNSURE, SLIGHT, DOUBT
OF_CLIPPED = LEAST_FREE, NEAR_END, HINT, TOLD, ALIKE
OF_SECOND = TWO, BESIDE, HINTED
NO_LOAD = Load(validity=Validity.NO_LOAD)
NO_PLANES = np.empty((0, 4, 0))


class OnePoint:
    """Called with the readings of a strain or stress array and their weights, gives the load, or None in any doubt.

    The answer is, to the last bit, that of the inverse in every cell and `localise`; the loops are theirs. Arguments:
    ``modulus`` E [Pa] of an array that measures strain; ``floor``: the largest signal that is no load.
    """

    def __init__(self, array: TaxelArray, modulus: float | None, floor: float) -> None:
        from tactile.inverse.point_numba import one_point  # numba is slow to import

        self._loop = one_point
        self._at = np.ascontiguousarray(array.positions().reshape(-1, 2), np.float64)
        self._strain, depth = array.quantity == "strain", array.depth
        self._layer = layer_field(array.thickness, depth, self._strain)
        size = 4 * np.pi / 3 * (modulus or 1.0) * depth * depth if self._strain else 2 * np.pi / 3 * depth * depth
        self._numbers = size, depth, float(floor)
        self._answer, self._cols = np.empty(19 + len(self._at)), array.cols

    def __call__(self, values: Floats, weights: Weights) -> Load | None:
        """Return the load that the readings (rows, cols, 3) say without doubt."""
        known = weights.scale, weights.trust, self._strain, self._layer, self._numbers, weights.noise or 0.0
        read = np.ascontiguousarray(values, np.float64)
        said = self._loop(
            read, NO_PLANES, self._at, *known, OF_ATTEMPT, OF_FIT, LIMITS, OF_CLIPPED, OF_SECOND, self._answer
        )
        return _load(said, self._answer, self._cols)


def of_answers(
    at: Floats, planes: Floats, depth: float, strain: bool, weights: Weights, layer: Floats, shape: tuple[int, int]
) -> Load | None:
    """Return the load that the taxels' answers (families, 4, n) at places (n, 2) [m] say without doubt, else None."""
    from tactile.inverse.point_numba import one_point  # numba is slow to import

    answer, read = np.empty(19 + len(at)), np.empty((*shape, 0))
    known = weights.scale, weights.trust, strain, layer, (0.0, depth, 0.0), weights.noise or 0.0
    said = one_point(read, planes, at, *known, OF_ATTEMPT, OF_FIT, LIMITS, OF_CLIPPED, OF_SECOND, answer)
    return _load(said, answer, shape[1])


def _load(said: int, answer: Floats, cols: int) -> Load | None:
    """Return what the compiled loops have said and filled in."""
    from tactile.inverse.point_numba import FOUND, NOT_SIMPLE  # numba is slow to import

    if said == NOT_SIMPLE:
        return None
    if said != FOUND:
        return NO_LOAD
    x, y, q, r, f, dx, dy, dq, dr, df, sx, sy, sq, sr, sf, misfit, taxels, inside, unread = answer[:19].tolist()
    validity = Validity.INSIDE if inside else Validity.OUTSIDE
    sigma, scatter = (dx, dy, dq, dr, df), (sx, sy, sq, sr, sf)
    out: tuple[tuple[int, int], ...] = ()
    if unread:
        out = tuple(divmod(int(cell), cols) for cell in answer[19 : 19 + int(unread)])
    return Load(x, y, q, r, f, sigma, misfit, int(taxels), validity, out, scatter=scatter)
