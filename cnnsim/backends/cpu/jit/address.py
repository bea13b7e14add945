"""Functions that are called by their address: compiled once, and in none of the functions that call them.

Numba links every function into the code of its callers and optimises it again there, in each caller of a caller, twin
and threaded loop. For the innermost loops that is most of the compiling; and of four, a template needs one.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import carray
from numba.core import cgutils
from numba.core.types import CPointer, int64, none  # type: ignore[attr-defined]
from numba.extending import intrinsic
from numpy.typing import NDArray

from cnnsim.backends.cpu.jit.compile import Kernel, helper, named
from cnnsim.support.compiled_loops import kept_cfunc


def compiled_at(function: Kernel, signature: Any) -> Any:
    """Compile a function, to disk as well; its ``address`` is good as long as it is kept."""
    return kept_cfunc(signature, error_model="numpy", nopython=True)(named(function, "_at"))


def pointer_type(dtype: np.dtype[Any]) -> Any:
    """Return the type of the address at which values of a dtype begin."""
    return CPointer(numba.from_dtype(dtype))


@intrinsic  # type: ignore[untyped-decorator]
def call(_typing: Any, _address: int, given: Any) -> Any:
    """Call what lies at an address with numbers and addresses, exactly of the types it was compiled for."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        address, arguments = values[0], cgutils.unpack_tuple(builder, values[1])
        nothing = context.get_value_type(none)
        function = ir.FunctionType(nothing, [value.type for value in arguments])
        builder.call(builder.inttoptr(address, function.as_pointer()), arguments)
        return context.get_dummy_value()

    return none(int64, given), code


@intrinsic  # type: ignore[untyped-decorator]
def pointer(_typing: Any, array: NDArray[Any]) -> Any:
    """Return the address at which an array's values begin, without a reference that would be counted."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    return CPointer(array.dtype)(array), code


@helper
def bare(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array's values as a flat array that counts no references, while somebody else keeps the array.

    Each slice of one that counts costs two atomic instructions, and threads that share it wait for one another there.
    """
    return carray(pointer(array), (array.size,))


@helper
def uncounted(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array of the same shape that counts no references: see `bare`."""
    return carray(pointer(array), array.shape)
