"""Whether a rest of a network is stable: whether all modes of I - A among its linear cells decay."""

from typing import Any

import numpy as np

_MOST_DENSE = 400
"""Cells of which all modes are computed, in a fifth of a second."""
_NEUTRAL = 1e-9
"""A mode slower than this part of the fastest one neither grows nor decays."""


def is_stable(leak: Any) -> bool | None:
    """Return whether every mode of dx/dt = -``leak`` x decays or stands still; None if that cannot be told.

    By Gershgorin's circles, which are enough for diffusion; else for a symmetric matrix by the signs of its factors
    (Sylvester's law of inertia); else by all of the modes.
    """
    if leak.shape[0] == 0:
        return True
    diagonal = leak.diagonal()
    if (diagonal < 0).any() and abs(leak - leak.T).max() < 1e-12:
        return False  # a definite matrix has no such entry
    around = np.asarray(abs(leak).sum(axis=1)).ravel() - np.abs(diagonal)
    if (diagonal >= around - _NEUTRAL * diagonal).all():
        return True
    if leak.shape[0] <= _MOST_DENSE:
        modes = np.linalg.eigvals(leak.toarray())
        return bool(modes.real.min() >= -_NEUTRAL * np.abs(modes).max())
    if abs(leak - leak.T).max() < 1e-12:
        return _definite(leak)
    return None


def _definite(leak: Any) -> bool | None:
    from scipy.sparse.linalg import splu  # slow to import, and only needed here

    try:
        factors = splu(leak, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError):
        return None
    if not np.array_equal(factors.perm_r, factors.perm_c):  # it had to exchange rows, so the signs say nothing
        return None
    return bool((factors.U.diagonal() > 0).all())
