"""How loops of the CPU backend are compiled: once, to disk, in a serial and a threaded version of one text.

Every version is compiled under a name of its own: their symbols meet in the loops that call them.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

import numba

from cnnsim.support.compiled_loops import kept_helper, kept_njit

Kernel = Callable[..., Any]

THREADS_PAY_FROM = 20_000
"""Cells (times taps or steps) of work below which starting the threads costs more than they save."""


class Twins(NamedTuple):
    """One function, compiled for one core and for all of them."""

    serial: Kernel
    threaded: Kernel

    def for_work(self, cells: int) -> Kernel:
        """Return the version that is faster for this much work."""
        return self.threaded if cells >= THREADS_PAY_FROM else self.serial


def threads_for(cells: int) -> int:
    """Return how many threads share this much work, in the version that `Twins.for_work` gives for it."""
    return numba.get_num_threads() if cells >= THREADS_PAY_FROM else 1


def helper(function: Kernel) -> Kernel:
    """Compile a function that is only called from other compiled ones."""
    return _compiled(function, "", kept_helper)


def fused(function: Kernel) -> Kernel:
    """Compile a helper in which a product and a sum may become one rounding (FMA).

    Nothing else of "fast" arithmetic is allowed: sums keep their order, and NaN stays NaN.
    """
    return _compiled(function, "_fused", kept_helper, fastmath={"contract"})


def reordered(function: Kernel) -> Kernel:
    """Compile a helper whose one sum may be added up in any order: a loop then adds in vectors."""
    return _compiled(function, "_reordered", kept_helper, fastmath={"reassoc", "contract"})


def kernel(function: Kernel) -> Kernel:
    """Compile a function for one core that Python calls."""
    return _compiled(function, "")


def twins(function: Kernel) -> Twins:
    """Compile a loop over `numba.prange` in both versions."""
    return Twins(_compiled(function, ""), _compiled(function, "_threaded", parallel=True))


def _compiled(function: Kernel, kind: str, how: Callable[..., Any] = kept_njit, **options: Any) -> Kernel:
    jitted: Kernel = how(error_model="numpy", **options)(named(function, kind))
    return jitted


def cache_folder(jitted: Any) -> str:
    """Return the folder of the disk cache."""
    return str(jitted.stats.cache_path)


def named(function: Kernel, kind: str) -> FunctionType:
    """Return a copy under a name that says how it is compiled."""
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, function.__name__ + kind)
    copy.__qualname__ = function.__qualname__ + kind
    copy.__module__ = function.__module__
    return copy
