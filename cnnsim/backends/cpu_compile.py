"""How loops of the CPU backend are compiled: once, to disk, in a serial and a threaded version of one text."""

from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

import numba

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


def helper(function: Kernel) -> Kernel:
    """Compile a function that is only called from other compiled ones."""
    jitted: Kernel = numba.njit(cache=True, error_model="numpy")(function)
    return jitted


def fused(function: Kernel) -> Kernel:
    """Compile a helper in which a product and a sum may become one rounding (FMA).

    Nothing else of "fast" arithmetic is allowed: sums keep their order, and NaN stays NaN.
    """
    jitted: Kernel = numba.njit(cache=True, error_model="numpy", fastmath={"contract"})(_named(function, "_fused"))
    return jitted


def twins(function: Kernel) -> Twins:
    """Compile a loop over `numba.prange` in both versions."""
    return Twins(
        numba.njit(cache=True, error_model="numpy")(function),
        numba.njit(cache=True, error_model="numpy", parallel=True)(_named(function, "_threaded")),
    )


def _named(function: Kernel, suffix: str) -> Kernel:
    """Copy a function under a name of its own, because numba's disk cache does not look at the options."""
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, function.__name__ + suffix)
    copy.__qualname__ = function.__qualname__ + suffix
    copy.__module__ = function.__module__
    return copy
