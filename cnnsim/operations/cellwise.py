"""Cellwise operations: functions of the values of planes at one cell, without neighbours."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Array, InputError
from cnnsim.support.errors import not_known

Planes = tuple[Array, ...]


@dataclass(frozen=True)
class Cellwise:
    """A named per-cell operation: some planes in, some planes out, numbers as parameters.

    ``array(*inputs, *parameters)`` defines the result: NumPy on arrays of any shape, giving one array an output.
    ``compiled()`` gives a kernel ``kernel(*inputs, *outputs, *parameters)`` for the CPU backend; the planes
    are contiguous 1-D arrays of one dtype, the outputs are written in place. Without it the CPU backend uses
    ``array``, which is as fast if the operation is a single NumPy ufunc. ``opencl`` is OpenCL C for one cell, such as
    ``"sum = p + q;"``: it reads inputs and parameters by name and sets the outputs; all have the type ``real`` (float
    or double).
    """

    name: str
    summary: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    array: Callable[..., Planes]
    compiled: Callable[[], Callable[..., None]] | None = None
    opencl: str = ""


BUILT_IN = {
    op.name: op
    for op in (
        Cellwise("add", "p + q", ("p", "q"), ("sum",), (), lambda p, q: (p + q,), opencl="sum = p + q;"),
        Cellwise(
            "subtract", "p - q", ("p", "q"), ("difference",), (), lambda p, q: (p - q,), opencl="difference = p - q;"
        ),
        Cellwise("multiply", "p * q", ("p", "q"), ("product",), (), lambda p, q: (p * q,), opencl="product = p * q;"),
        Cellwise(
            "minimum",
            "min(p, q)",
            ("p", "q"),
            ("least",),
            (),
            lambda p, q: (np.minimum(p, q),),
            opencl="least = (p < q) | (p != p) ? p : q;",  # NaN comes through, as in NumPy
        ),
        Cellwise(
            "maximum",
            "max(p, q)",
            ("p", "q"),
            ("most",),
            (),
            lambda p, q: (np.maximum(p, q),),
            opencl="most = (p > q) | (p != p) ? p : q;",
        ),
        Cellwise("absolute", "|p|", ("p",), ("size",), (), lambda p: (np.abs(p),), opencl="size = fabs(p);"),
        Cellwise(
            "scale",
            "factor * p + offset, in the plane's own precision",
            ("p",),
            ("scaled",),
            ("factor", "offset"),
            lambda p, factor, offset: (p.dtype.type(factor) * p + p.dtype.type(offset),),
            opencl="scaled = factor * p + offset;",
        ),
    )
}


def find(name: str) -> Cellwise:
    """Return the operation called ``name``: a built-in one, or one that an installed package announces.

    Packages announce theirs under the entry-point group ``cnnsim.cellwise``.

    Raises:
        InputError: no operation has the name.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]
    from importlib.metadata import entry_points  # reads a good deal, for names that are not built in

    announced = {point.name: point for point in entry_points(group="cnnsim.cellwise")}
    if name not in announced:
        raise not_known("no cellwise operation is called", name, sorted({*BUILT_IN, *announced}))
    operation = announced[name].load()
    if not isinstance(operation, Cellwise):
        raise InputError(f"cellwise operation {name!r} is announced as a {type(operation).__name__}")
    return operation
