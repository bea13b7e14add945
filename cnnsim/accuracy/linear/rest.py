"""The rest of a linear template near a state: the outputs at which nothing moves any more, solved for directly.

At rest y = clip(A y + w). With the cells known that are saturated there, the others solve (I - A) y = w + what the
saturated ones add: a sparse linear system, the five-point Laplacian for diffusion. Where the solution saturates other
cells it is solved again with those (Newton's method for piecewise linear equations).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.accuracy.linear.solve import solve_sparse
from cnnsim.accuracy.linear.stable import is_stable
from cnnsim.accuracy.linear.system import LinearSystem
from cnnsim.support import Flags, Floats

_ROUNDS = 30
_ROUNDING = 1e-9
"""Of a solution's residual, for drives of size 1."""


@dataclass(frozen=True)
class Rest:
    """The outputs ``y`` and drives (both (cells,)) at which a network rests, and the cells that are ``linear`` there.

    ``stable``: it is the end of all transients near it. If it is not, the linear cells stand on a ridge: what they
    become is decided by the smallest push.
    """

    y: Floats
    drive: Floats
    linear: Flags
    stable: bool


def find_rest(system: LinearSystem, x: Floats, tolerance: float) -> Rest | None:
    """Return the rest to which a state (cells,) that hardly moves any more is going, with y to the tolerance.

    None: it cannot be told, because Newton's method found none, or because the state could end elsewhere.
    """
    drive = system.matrix @ x.clip(-1, 1) + system.drive
    found = _newton(system, x, system.free & (np.abs(drive) < 1), tolerance)
    if found is None and system.definite:  # there is one rest; from far off no cell is known to be saturated there
        found = _newton(system, x, system.free, tolerance)
    if found is None:
        return None
    y, linear, leak = found
    stable = True if system.definite else is_stable(leak)
    if stable is None or (stable and not _sure(system, x, y, linear)):
        return None
    return Rest(y, system.matrix @ y + system.drive, linear, stable)


def _newton(system: LinearSystem, x: Floats, linear: Flags, tolerance: float) -> tuple[Floats, Flags, Any] | None:
    """Return the outputs at rest, the linear cells and I - A among them; ``linear`` are those to begin with."""
    matrix, free = system.matrix, system.free
    y = x.clip(-1, 1)
    for _ in range(_ROUNDS):
        drive = matrix @ y + system.drive
        y = np.where(free & ~linear, np.sign(drive), y)
        drive = matrix @ y + system.drive
        cells = np.flatnonzero(linear)
        leak = _leak(matrix, cells)
        step = solve_sparse(leak, (drive - y)[cells], tolerance, system.inverse if cells.size == y.size else None)
        if step is None:
            return None
        y[cells] += step
        drive = matrix @ y + system.drive
        now = free & (np.abs(drive) < 1)
        if np.array_equal(now, linear):
            wrong = np.abs(np.where(free, drive.clip(-1, 1) - y, 0.0)).max(initial=0.0)
            return (y, linear, leak) if wrong <= max(_ROUNDING, tolerance / 10) else None
        y = np.where(free, y.clip(-1, 1), y)
        linear = now
    return None


def _leak(matrix: Any, cells: Any) -> Any:
    """Return I - A among some cells."""
    from scipy.sparse import identity  # as in `solve`

    return (identity(cells.size, format="csr") - matrix[cells][:, cells]).tocsc()


def _sure(system: LinearSystem, x: Floats, y: Floats, linear: Flags) -> bool:
    """Return whether a state goes to this rest and to no other.

    There is no other if I - A is definite among all free cells; else the state must be so near that no cell of it can
    meet a kink on its way: the distance (in the sum of squares) of a symmetric network only shrinks.
    """
    if system.definite or is_stable(_leak(system.matrix, np.flatnonzero(system.free))):
        return True
    away = float(np.linalg.norm(np.where(system.free, x.clip(-1, 1) - y, 0.0)))
    margin = float((1 - np.abs(y[linear])).min(initial=1.0))
    return away < margin
