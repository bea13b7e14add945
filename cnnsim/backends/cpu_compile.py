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


def twins(function: Kernel) -> Twins:
    """Compile a loop over `numba.prange` in both versions.

    The threaded one gets a name of its own, because numba's disk cache does not look at the threading option.
    """
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, function.__name__ + "_threaded")
    copy.__qualname__ = function.__qualname__ + "_threaded"
    copy.__module__ = function.__module__
    return Twins(
        numba.njit(cache=True, error_model="numpy")(function),
        numba.njit(cache=True, error_model="numpy", parallel=True)(copy),
    )
