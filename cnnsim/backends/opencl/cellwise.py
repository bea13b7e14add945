"""Per-cell operations as OpenCL kernels: the operation's text inside a loop over the cells."""

from cnnsim.operations.cellwise import Cellwise
from cnnsim.support import InputError

VECTORS = """#ifdef CPU
#ifdef DOUBLE
#define sqrt __builtin_sqrt
#define fabs __builtin_fabs
#else
#define sqrt __builtin_sqrtf
#define fabs __builtin_fabsf
#endif
#pragma clang loop vectorize(assume_safety)
#endif
"""
"""What compilers need to make vectors of the cells on a CPU: PoCL calls functions for its own roots and sizes, and
forgets `restrict` (no plane lies in another). One cell at a time takes ten times as long."""


def text(operation: Cellwise) -> str:
    """Return a kernel ``cellwise(inputs..., outputs..., parameters..., count)`` around an operation's text.

    Raises:
        InputError: the operation has no OpenCL text.
    """
    if not operation.opencl:
        raise InputError(
            f"cellwise operation {operation.name!r} has no OpenCL text; give it one (`Cellwise.opencl`), "
            "or run on the cpu backend"
        )
    arguments = [f"__global const real *restrict in_{name}" for name in operation.inputs]
    arguments += [f"__global real *restrict out_{name}" for name in operation.outputs]
    arguments += [f"const real {name}" for name in operation.parameters] + ["const long count"]
    lines = [f"const real {name} = in_{name}[cell];" for name in operation.inputs]
    lines += [f"real {name};" for name in operation.outputs]
    stores = [f"out_{name}[cell] = {name};" for name in operation.outputs]
    body = "\n".join((*lines, operation.opencl, *stores))
    return f"KERNEL void cellwise({', '.join(arguments)})\n{{\n{VECTORS}EACH(cell, count) {{\n{body}\n}}\n}}\n"
