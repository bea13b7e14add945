"""The rest of a linear template near a state, solved for directly, and whether it is stable.

At rest y = clip(A y + w). If the saturated cells are known, the others solve (I - A) y = w + the saturated part: a
sparse linear system, the five-point Laplacian for diffusion. If the solution changes the set of saturated cells, the
system is solved again with the new set (Newton's method for piecewise linear equations).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.solver.linear_system import LinearSystem
from cnnsim.solver.sparse_solve import solve_sparse
from cnnsim.support import Flags, Floats

_ROUNDS = 30
_ROUNDING = 1e-9
"""Largest residual of a solution that is attributed to rounding, for drives of size 1."""
_MOST_DENSE = 400
"""Most cells for which all modes are computed; this takes a fifth of a second."""
_ITERATIONS = 300
"""Restarts of Arnoldi's iteration for the slowest mode of a larger matrix."""
_NEUTRAL = 1e-9
"""A mode slower than this part of the fastest one neither grows nor decays."""


@dataclass(frozen=True)
class Rest:
    """The outputs ``y`` and drives (both (cells,)) at which a network rests, and the cells that are ``linear`` there.

    ``stable``: all transients near it end there. If False the linear cells are on a separatrix: the smallest
    perturbation decides where they go. If None, this is no rest but a state farther from one than the tolerance, or
    one that drifts: a mode that does not decay has a constant rate.
    """

    y: Floats
    drive: Floats
    linear: Flags
    stable: bool | None


def find_rest(system: LinearSystem, x: Floats, tolerance: float) -> Rest | None:
    """Return the rest that a state (cells,) with a small rate approaches, with y to the tolerance.

    None: Newton's method found none near the state, or the state could end elsewhere.
    """
    drive = system.matrix @ x.clip(-1, 1) + system.drive
    linear = system.free & (np.abs(drive) < 1)
    found = _newton(system, x, linear, tolerance)
    if found is None and system.definite:  # there is one rest; far from it, assume no saturated cells
        found = _newton(system, x, system.free, tolerance)
    if found is not None:
        y, at_rest, leak = found
        stable = True if system.definite else is_stable(leak)
        if stable is False or (stable and _is_approached(system, x, y, at_rest)):
            return Rest(y, system.matrix @ y + system.drive, at_rest, stable)
    cells = np.flatnonzero(linear)
    step = solve_sparse(_leak(system.matrix, cells), (drive - x.clip(-1, 1))[cells], tolerance)
    far = step is not None and np.abs(step).max(initial=0.0) > tolerance
    return Rest(x, drive, linear, None) if far else None


def _newton(system: LinearSystem, x: Floats, linear: Flags, tolerance: float) -> tuple[Floats, Flags, Any] | None:
    """Return the outputs at rest, the linear cells, and I - A restricted to these; ``linear`` is the first guess."""
    matrix, free = system.matrix, system.free
    y = x.clip(-1, 1)
    for _ in range(_ROUNDS):
        drive = matrix @ y + system.drive
        y = np.where(free & ~linear, np.sign(drive), y)
        drive = matrix @ y + system.drive
        cells = np.flatnonzero(linear)
        leak = _leak(matrix, cells)
        step = solve_sparse(leak, (drive - y)[cells], tolerance, system.inverse if cells.size == y.size else None)
        if step is None or np.isinf(step).any():
            return None
        y[cells] += step
        drive = matrix @ y + system.drive
        now = free & (np.abs(drive) < 1)
        if np.array_equal(now, linear):
            wrong = np.abs(np.where(free, drive.clip(-1, 1) - y, 0.0)).max(initial=0.0)
            return (y, linear, leak) if wrong <= _ROUNDING else None
        y = np.where(free, y.clip(-1, 1), y)
        linear = now
    return None


def _leak(matrix: Any, cells: Any) -> Any:
    """Return I - A restricted to some cells."""
    from scipy.sparse import identity  # slow to import, and only needed here

    return (identity(cells.size, format="csr") - matrix[cells][:, cells]).tocsc()


def _is_approached(system: LinearSystem, x: Floats, y: Floats, linear: Flags) -> bool:
    """Return whether a state approaches this rest and no other.

    There is no other if I - A, restricted to the free cells, is definite. Otherwise the state must be so near that no
    linear cell can reach a kink: the Euclidean distance to the rest of a symmetric network never grows.
    """
    if system.definite or is_stable(_leak(system.matrix, np.flatnonzero(system.free))):
        return True
    away = float(np.linalg.norm(np.where(system.free, x.clip(-1, 1) - y, 0.0)))
    margin = float((1 - np.abs(y[linear])).min(initial=1.0))
    return away < margin


def is_stable(leak: Any, neutral: float = _NEUTRAL) -> bool | None:
    """Return whether every mode of dx/dt = -``leak`` x decays or is constant; None if this is unknown.

    Gershgorin's circles decide first; they are enough for diffusion. Then the eigenvalues of a small matrix decide, or
    for a large symmetric one the signs of its factors (Sylvester's law of inertia). A mode slower than the part
    ``neutral`` of the fastest one counts as constant.
    """
    if leak.shape[0] == 0:
        return True
    diagonal = leak.diagonal()
    symmetric = abs(leak - leak.T).max() < 1e-12
    if diagonal.sum() < 0 or (symmetric and (diagonal < 0).any()):
        return False  # the sum is that of all modes, and a definite matrix has no such entry
    around = np.asarray(abs(leak).sum(axis=1)).ravel() - np.abs(diagonal)
    if (diagonal >= around - neutral * diagonal).all():
        return True
    if leak.shape[0] <= _MOST_DENSE:
        modes = np.linalg.eigvals(leak.toarray())
        return bool(modes.real.min() >= -neutral * np.abs(modes).max())
    return _is_definite_matrix(leak) if symmetric else _slowest(leak, neutral)


def _slowest(leak: Any, neutral: float) -> bool | None:
    """Return whether the mode of the smallest real part decays; Arnoldi's iteration for one mode may miss it."""
    from scipy.sparse.linalg import ArpackError, eigs  # slow to import, and only needed here

    start = np.random.default_rng(0).normal(size=leak.shape[0])
    try:
        slowest = eigs(leak, k=6, ncv=80, which="SR", v0=start, maxiter=_ITERATIONS, return_eigenvectors=False)
    except ArpackError:
        return None
    return bool(slowest.real.min() >= -neutral * abs(leak).sum(axis=1).max())


def _is_definite_matrix(leak: Any) -> bool | None:
    from scipy.sparse.linalg import splu  # slow to import, and only needed here

    try:
        factors = splu(leak, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError):
        return None
    if not np.array_equal(factors.perm_r, factors.perm_c):  # with rows exchanged the signs say nothing
        return None
    return bool((factors.U.diagonal() > 0).all())
