"""Expected outputs of the gray-scale templates: filters, thresholds, linear systems and matrix exponentials."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import linalg, ndimage

from tests.oracles.pictures import Case, Plane, black, plane
from tests.oracles.wholes import flood

Matrix = npt.NDArray[np.float64]


def clip(x: Plane) -> Plane:
    """The output of a state."""
    return np.clip(x, -1.0, 1.0)


def weighted_sum(picture: Plane, weights: Matrix, outside: float | None) -> Plane:
    """The weighted sum of every cell's neighbourhood; the top row of the weights is north. None: zero-flux boundary."""
    how = {"mode": "nearest"} if outside is None else {"mode": "constant", "cval": outside}
    return np.asarray(ndimage.correlate(picture, weights, **how), dtype=np.float64)


def filtered(weights: npt.ArrayLike) -> Callable[[Case], Plane]:
    """A linear filter of the input."""
    return lambda case: clip(weighted_sum(case.picture, np.array(weights, dtype=float), None))


def neighbour_mean(case: Case) -> Plane:
    """The mean of the eight neighbours."""
    u = case.picture
    return (9 * np.asarray(ndimage.uniform_filter(u, 3, mode="nearest")) - u) / 8


def binomial(case: Case) -> Plane:
    """The (1, 2, 1)/4 smoothing along the rows and then along the columns."""
    along_rows = ndimage.correlate1d(case.picture, [0.25, 0.5, 0.25], axis=1, mode="nearest")
    return np.asarray(ndimage.correlate1d(along_rows, [0.25, 0.5, 0.25], axis=0, mode="nearest"))


def laplacian(case: Case) -> Plane:
    """A quarter of the negative five-point Laplacian."""
    return clip(-np.asarray(ndimage.laplace(case.picture, mode="nearest"), dtype=float) / 4)


def column_gradient(case: Case) -> Plane:
    """The central difference along the rows, smoothed along the columns with weights 0.11, 0.28, 0.11."""
    difference = ndimage.correlate1d(case.picture, [-1, 0, 1], axis=1, mode="nearest")
    return clip(np.asarray(ndimage.correlate1d(difference, [0.11, 0.28, 0.11], axis=0, mode="nearest")))


INVERSE_HALFTONE_5 = [
    [0.0049, 0.014, 0.0198, 0.014, 0.0049],
    [0.014, 0.0648, 0.092, 0.0648, 0.014],
    [0.0198, 0.092, 0.162, 0.092, 0.0198],
    [0.014, 0.0648, 0.092, 0.0648, 0.014],
    [0.0049, 0.014, 0.0198, 0.014, 0.0049],
]


def above(threshold: float) -> Callable[[Case], Plane]:
    """Black where the picture is above the threshold; a tie is not allowed."""

    def solve(case: Case) -> Plane:
        assert (case.picture != threshold).all()
        return plane(case.picture > threshold)

    return solve


def gray_edge(case: Case) -> Plane:
    """Black where nine times the cell exceeds the sum of its window by more than one half."""
    total = 9 * np.asarray(ndimage.uniform_filter(case.picture, 3, mode="nearest"))
    excess = 9 * case.picture - total - 0.5
    assert (np.abs(excess) > 1e-9).all()
    return plane(excess > 0)


def bistable(self_feedback: float, weights: npt.ArrayLike, z: float) -> Callable[[Case], Plane]:
    """An uncoupled cell with a > 1 falls to the side that (a - 1) x(0) + drive points to (white outside).

    A drive stronger than a - 1 decides alone.
    """

    def solve(case: Case) -> Plane:
        drive = weighted_sum(case.picture, np.array(weights, dtype=float), -1.0) + z
        push = (self_feedback - 1) * clip(case.start)
        side = np.where(np.abs(drive) > self_feedback - 1, drive, push + drive)
        assert (np.abs(side) > 1e-9).all()
        return plane(side > 0)

    return solve


STEEP_DIAGONAL: list[list[float]] = [
    [-1, -1, -1, 0.5, 1],
    [-1, -1, 1, 1, 0.5],
    [-1, 1, 5, 1, -1],
    [0.5, 1, 1, -1, -1],
    [1, 0.5, -1, -1, -1],
]
LATERAL_INHIBITION = np.full((5, 5), -0.1)
LATERAL_INHIBITION[2, 2] = 1.3


# --- linear networks ----------------------------------------------------------------------------------------------


def coupling(weights: npt.ArrayLike, shape: tuple[int, int], repeat_border: bool) -> Matrix:
    """The matrix from a plane to its weighted sums; cells outside are 0 or repeat the nearest cell."""
    kernel = np.array(weights, dtype=float)
    cells = np.eye(shape[0] * shape[1]).reshape(-1, *shape)
    sums = [weighted_sum(cell, kernel, None if repeat_border else 0.0).ravel() for cell in cells]
    return np.stack(sums, axis=1)


HEAT = [[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]]
FIVE_POINT = [[0, 1, 0], [1, -4, 1], [0, 1, 0]]


def heat(case: Case, time: float = 5.0) -> Plane:
    """The state after some time constants of dx/dt = K x - x, by the matrix exponential."""
    start = case.start
    rate = coupling(HEAT, start.shape, repeat_border=True) - np.eye(start.size)
    return np.asarray(linalg.expm(rate * time) @ start.ravel(), dtype=float).reshape(start.shape)


def anchored_heat(case: Case) -> Plane:
    """The rest x = (K x + K u) / 2 of the diffusion that half listens to its input."""
    u = case.picture
    half = coupling(HEAT, u.shape, repeat_border=True) / 2
    rest = np.linalg.solve(np.eye(u.size) - half, half @ u.ravel())
    return np.asarray(rest, dtype=np.float64).reshape(u.shape)


def membrane(weights: npt.ArrayLike, repeat_border: bool) -> Callable[[Case], Plane]:
    """The steady state 0 = L x + bias of a linear relaxation in which masked cells keep their state."""

    def solve(case: Case) -> Plane:
        x = case.start.astype(float).ravel().copy()
        free = np.ones(x.size, dtype=bool) if case.mask is None else ~case.mask.ravel()
        load = np.zeros(x.size) if case.bias is None else case.bias.ravel()
        operator = coupling(weights, case.start.shape, repeat_border)
        known = operator[np.ix_(free, ~free)] @ x[~free] + load[free]
        x[free] = np.linalg.solve(operator[np.ix_(free, free)], -known)
        assert (np.abs(x) <= 1).all(), "the relaxation leaves the linear range"
        return x.reshape(case.start.shape)

    return solve


BIHARMONIC = -2.0 * np.array(
    [
        [0, 0, 1, 0, 0],
        [0, 2, -8, 2, 0],
        [1, -8, 20, -8, 1],
        [0, 2, -8, 2, 0],
        [0, 0, 1, 0, 0],
    ]
)


def running_row_sum(case: Case) -> Plane:
    """A twentieth of the sum of each row up to the cell."""
    return clip(0.05 * np.cumsum(case.picture, axis=1))


def one_way_trigger(case: Case) -> Plane:
    """A wave that has had time to reach every cell it can reach."""
    return plane(flood(case))


def nothing_left(case: Case) -> Plane:
    """All white, but for masked cells."""
    kept = np.zeros_like(black(case.start)) if case.mask is None else case.mask
    return plane(black(case.start) & kept)


ANSWERS: dict[str, Callable[[Case], Plane]] = {
    "edge-gray": gray_edge,
    "threshold": above(0.4),
    "threshold-zero": above(0.0),
    "copy": lambda case: clip(case.picture),
    "average": neighbour_mean,
    "lowpass": binomial,
    "laplacian": laplacian,
    "optimal-edge": column_gradient,
    "inverse-halftone-3x3": filtered([[0.07, 0.1, 0.07], [0.1, 0.32, 0.1], [0.07, 0.1, 0.07]]),
    "inverse-halftone-5x5": filtered(INVERSE_HALFTONE_5),
    "approximate-diagonal-detector": bistable(2, STEEP_DIAGONAL, -13),
    "muller-lyer": bistable(1.3, LATERAL_INHIBITION, -2.8),
    "diffusion": heat,
    "constrained-diffusion": anchored_heat,
    "laplace-solver": membrane(FIVE_POINT, repeat_border=True),
    "poisson-solver": membrane(FIVE_POINT, repeat_border=False),
    "surface-interpolation": membrane(BIHARMONIC, repeat_border=False),
    "majority-vote-1": running_row_sum,
    "trigger-wave": one_way_trigger,
    "trigger-wave-white": nothing_left,
}
"""The answer of every gray-scale template that has an independent definition, to a worked example."""
