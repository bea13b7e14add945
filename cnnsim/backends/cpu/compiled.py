"""Compilation of the CPU loops: serial and threaded versions, calls by address, and tables as arrays of records.

Each function is compiled once and kept on disk. Numba links a function into the code of every caller and optimises it
again there. The innermost loops are therefore compiled apart and called by their address, which more than halves the
time of compilation; a template also needs only one of several.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import carray
from numba.core import cgutils
from numba.core.types import CPointer, int64, none  # type: ignore[attr-defined]
from numba.extending import intrinsic

from cnnsim.network import Tap
from cnnsim.support import Array
from cnnsim.support.compiled_loops import kept_cfunc, kept_helper, kept_njit

Kernel = Callable[..., Any]

THREADS_PAY_FROM = 20_000
"""Cells (times taps or steps) of work below which starting the threads costs more than they save."""


class Twins(NamedTuple):
    """One function, compiled for one thread and for several."""

    serial: Kernel
    threaded: Kernel

    def for_work(self, cells: int) -> Kernel:
        """Return the version that is faster for this much work."""
        return self.threaded if cells >= THREADS_PAY_FROM else self.serial


def threads_for(cells: int) -> int:
    """Return how many threads share this much work in the version that `Twins.for_work` returns."""
    return numba.get_num_threads() if cells >= THREADS_PAY_FROM else 1


def helper(function: Kernel) -> Kernel:
    """Compile a function that only compiled functions call; it is inlined, so that slices cost no reference counts."""
    return _compiled(function, "", kept_helper, forceinline=True)


def fused(function: Kernel) -> Kernel:
    """Compile a helper in which a product and a sum may become one rounding (FMA).

    No other "fast" arithmetic is allowed: sums keep their order, and NaN stays NaN.
    """
    return _compiled(function, "_fused", kept_helper, fastmath={"contract"})


def reordered(function: Kernel) -> Kernel:
    """Compile a helper whose sum may be added in any order, so that the loop is vectorised."""
    return _compiled(function, "_reordered", kept_helper, fastmath={"reassoc", "contract"})


def without_nan(function: Kernel) -> Kernel:
    """Compile a helper with a vectorised maximum; its result is undefined if a value is NaN."""
    return _compiled(function, "_without_nan", kept_helper, fastmath={"nnan", "nsz"})


def kernel(function: Kernel) -> Kernel:
    """Compile a function for one thread that Python calls."""
    return _compiled(function, "")


def twins(function: Kernel) -> Twins:
    """Compile a loop over `numba.prange` in both versions."""
    return Twins(_compiled(function, ""), _compiled(function, "_threaded", parallel=True))


def compiled_at(function: Kernel, signature: Any, **options: Any) -> Any:
    """Compile a function that is called by its ``address``, which is valid while the returned object lives."""
    return kept_cfunc(signature, error_model="numpy", nopython=True, **options)(_named(function, "_at"))


def _compiled(function: Kernel, suffix: str, how: Callable[..., Any] = kept_njit, **options: Any) -> Kernel:
    jitted: Kernel = how(error_model="numpy", **options)(_named(function, suffix))
    return jitted


def _named(function: Kernel, suffix: str) -> FunctionType:
    """Return a copy under another name: versions of a function that meet in one caller need different symbols."""
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, function.__name__ + suffix)
    copy.__qualname__ = function.__qualname__ + suffix
    copy.__module__ = function.__module__
    return copy


def cache_folder(jitted: Any) -> str:
    """Return the folder of the disk cache."""
    return str(jitted.stats.cache_path)


@intrinsic  # type: ignore[untyped-decorator]
def call(_typing: Any, _address: int, given: Any) -> Any:
    """Call the function at an address with arguments of exactly the types that it was compiled for."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        address, arguments = values[0], cgutils.unpack_tuple(builder, values[1])
        nothing = context.get_value_type(none)
        function = ir.FunctionType(nothing, [value.type for value in arguments])
        builder.call(builder.inttoptr(address, function.as_pointer()), arguments)
        return context.get_dummy_value()

    return none(int64, given), code


def pointer_type(dtype: np.dtype[Any]) -> Any:
    """Return the type of a pointer to values of a dtype."""
    return CPointer(numba.from_dtype(dtype))


@intrinsic  # type: ignore[untyped-decorator]
def pointer(_typing: Any, array: Array) -> Any:
    """Return a pointer to an array's first value."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    return CPointer(array.dtype)(array), code


@helper
def uncounted(array: Array) -> Array:
    """Return the same contiguous array without a reference count; the caller keeps the original alive.

    A slice of a counted array costs two atomic instructions, and threads that share an array wait for each other there.
    """
    return carray(pointer(array), array.shape)


def records(**columns: Array) -> Array:
    """Return columns of one length as an array of records with the columns' names as fields."""
    size = len(next(iter(columns.values())))
    table = np.empty(size, np.dtype([(name, column.dtype) for name, column in columns.items()], align=True))
    for name, column in columns.items():
        table[name] = column
    return table


def tap_records(taps: tuple[Tap, ...], dtype: np.dtype[Any]) -> Array:
    """Return taps as records (k, l, weight)."""
    return np.array([tuple(tap) for tap in taps], tap_type(dtype))


def tap_type(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """Return the dtype of a tap's record."""
    return np.dtype([("k", np.int64), ("l", np.int64), ("weight", dtype)], align=True)
