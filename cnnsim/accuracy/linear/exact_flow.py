"""The exact flow of a linear template: from kink to kink, each located, and between them by the matrix exponential.

While no cell enters or leaves its saturation the network is linear, dx/dt = J x + c, and x(t) = exp(J t) x0 + ... is
its Taylor series, whose terms are products of the sparse matrix and a vector. A cell's x(t) is then a polynomial, and
the first time at which one of them meets -1 or +1 is the next kink: there the state is computed, the cell changes its
piece, and a new series begins. Nothing is cut off but the tail of the series, below 1e-16.
"""

from typing import NamedTuple

import numpy as np

from cnnsim.accuracy.linear.system import LinearSystem
from cnnsim.support import Floats, InputError


def exact_state(system: LinearSystem, x: Floats, duration: float, most_kinks: int = 10**6) -> Floats:
    """Return x(``duration``) of a state (cells,), to about 1e-13 times the growth of rounding errors.

    Raises:
        InputError: more kinks than ``most_kinks`` (a network that never rests).
    """
    found = exact_flow(system, x, np.zeros(x.shape), duration, most_kinks)
    if found.left:
        after = duration - found.left
        raise InputError(f"more than {most_kinks} kinks after {after:g} time constants; a shorter duration wanted")
    return found.x


class Flow(NamedTuple):
    """A state and a push of it (both (cells,)) after some time, kinks met, time left, evaluations of A y."""

    x: Floats
    push: Floats
    kinks: int
    left: float
    evaluations: int


def exact_flow(system: LinearSystem, x: Floats, push: Floats, duration: float, most_kinks: int) -> Flow:
    """Return x(``duration``) of a state (cells,), and by how much a small ``push`` of it moves that.

    The push (cells,) goes through the same linear pieces as the state: no kink makes it jump, as A y has none. Time is
    left where there are more than ``most_kinks``.
    """
    from cnnsim.accuracy.linear.exact_loops import flow  # numba is slow to import, and only needed for exact answers

    x, push = x.astype(np.float64), push.astype(np.float64)
    piece = np.sign(x) * (np.abs(x) > 1)
    edge = np.abs(x) == 1
    if edge.any():  # on a kink the piece is that to which the cell goes
        outwards = np.sign(x) * (system.matrix @ x.clip(-1, 1) + system.drive - x) >= 0
        piece[edge & outwards] = np.sign(x[edge & outwards])
    piece[~system.free] = np.sign(x[~system.free]) * (np.abs(x[~system.free]) >= 1)
    matrix = system.matrix
    kinks, left, evaluations = flow(
        matrix.indptr, matrix.indices, matrix.data, system.drive, system.free, system.limited, x, push, piece,
        float(duration), 2.0 / system.norm, most_kinks,
    )  # fmt: skip
    return Flow(x, push, int(kinks), float(left), int(evaluations))
