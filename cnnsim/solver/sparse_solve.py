"""Sparse linear systems of networks at rest: LU factors, or conjugate gradients for large ones."""

import warnings
from typing import Any

import numpy as np

from cnnsim.solver.spectrum import Inverse
from cnnsim.support import Floats

MOST_FACTORED = 20_000
"""Cells whose matrix is factored: of a biharmonic surface 141 x 141, in about a second and 200 MB."""
_MOST_ITERATIONS = 600
"""A round: beyond that a state reaches its rest faster by steps."""
_FAR = 1e9
"""Growth of a probe from which on the matrix counts as singular."""
_SHIFT = 1e-7
"""Added to the diagonal of a singular matrix: what the matrix reaches is solved for in a few rounds."""
_DRIFT = 1e-12
"""Residual from which on a right side counts as out of the reach of a singular matrix, for outputs of size 1."""


def solve_sparse(leak: Any, right: Floats, tolerance: float, inverse: Inverse | None = None) -> Floats | None:
    """Return v with ``leak`` v = ``right`` to about the tolerance, None if none is found.

    ``inverse`` is an approximate inverse of the matrix, if known (see `spectrum`).

    Where the matrix is singular (diffusion that keeps its mean) it is the remaining change of a transient with this
    rate: infinite if the rate has a part that never decays.
    """
    if not right.size or not right.any():
        return np.zeros_like(right)
    small, symmetric = right.size <= MOST_FACTORED, abs(leak - leak.T).max() < 1e-12
    found = _by_factors(leak, right) if small else None
    if small:  # singular: plain gradients stay in what the matrix reaches
        inverse = inverse or (lambda v: v)
    if found is None and symmetric:
        found = _by_gradients(leak, right, tolerance, inverse)
    return _by_shift(leak, right, tolerance, inverse) if found is None and (small or symmetric) else found


def _by_shift(leak: Any, right: Floats, tolerance: float, inverse: Inverse | None) -> Floats | None:
    """Return the solution of a singular system without a part in the null space, infinite if there is none."""
    from scipy.sparse import identity  # as below
    from scipy.sparse.linalg import splu

    shifted = (leak + _SHIFT * identity(right.size)).tocsc()
    factors = splu(shifted) if right.size <= MOST_FACTORED else None
    found = np.zeros_like(right)
    for _ in range(3):
        left = right - leak @ found
        more = factors.solve(left) if factors is not None else _by_gradients(shifted, left, tolerance, inverse)
        if more is None or not np.isfinite(more).all():
            return None
        found = found + more
    left = right - leak @ found
    reached = np.abs(left).max() <= _DRIFT + 1e-9 * np.abs(right).max()
    return found if reached else np.full_like(right, np.inf)


def _by_factors(leak: Any, right: Floats) -> Floats | None:
    from scipy.sparse.linalg import splu  # slow to import, and only needed where a rest is solved for

    try:
        factors = splu(leak)
    except RuntimeError:  # exactly singular
        return None
    found = factors.solve(right)
    probe = np.sin(np.arange(right.size) + 0.5)  # nearly singular: almost any drive leads far away
    if np.abs(leak @ found - right).max() > 1e-9 * np.abs(right).max() or np.abs(factors.solve(probe)).max() > _FAR:
        return None
    return found


def _by_gradients(leak: Any, right: Floats, tolerance: float, inverse: Inverse | None) -> Floats | None:
    from scipy.sparse.linalg import LinearOperator, cg  # as above

    diagonal = leak.diagonal()
    if (diagonal <= 0).any():
        return None
    found = np.zeros_like(right)
    precondition = LinearOperator(leak.shape, inverse or (lambda v: v / diagonal), dtype=np.float64)
    for _ in range(4):  # each round takes the residual down by 1e-5
        left = right - leak @ found
        if np.abs(left).max() <= 1e-10 * np.abs(right).max():
            return found
        with np.errstate(all="ignore"), warnings.catch_warnings():  # of a singular matrix
            warnings.simplefilter("ignore", RuntimeWarning)
            change, failed = cg(leak, left, maxiter=_MOST_ITERATIONS, M=precondition)
        if failed or not np.isfinite(change).all():
            return None
        found = found + change
        if np.abs(change).max() <= tolerance / 10:
            return found
    return None
