"""Where transients are computed: `get` finds a backend by its name.

From `cnnsim.run_transient` to the innermost loop are five calls at most: the backend's ``transient``, the time loop
(`driver.run`), the stepper's ``advance``, on the CPU the compiled loop over steps, and in it the loop over rows; with
OpenCL the launch of a kernel. The steps by tiles of the CPU check in their compiled loop: ``transient``,
``by_tiles``, `dense` or `sleeping`, a tile, its rows.
"""

from importlib import import_module

from numpy.typing import DTypeLike

from cnnsim.backends.base import Backend, parse_dtype
from cnnsim.support import InputError
from cnnsim.support.errors import not_known
from cnnsim.support.extras import install_line

NAMES = ("reference", "cpu", "opencl")
"""Each is a folder of this package, whose module ``backend`` has the class as ``BACKEND``."""


def get(
    name: str = "cpu", dtype: DTypeLike | None = None, device: str | None = None, threads: int | None = None
) -> Backend:
    """Return the backend called ``name``, working in ``dtype`` (its own default if None).

    ``device`` is a number or a part of a name, for backends that have a choice; ``threads`` of the cpu backend, from 1
    to the number of cores, None for as many as pay on a grid.

    Raises:
        InputError: no such backend, one that is not installed, or one that cannot work in this dtype.
    """
    if name not in NAMES:
        if name.lower() in ("gpu", "cuda"):  # by its letters the cpu would be the nearest
            raise InputError(f"backend {name!r}; known are {', '.join(NAMES)}; did you mean 'opencl'?")
        raise not_known("backend", name, NAMES)
    if device is not None and name != "opencl":
        raise InputError(f"device {device!r} for the {name} backend; only the opencl backend has a choice of devices")
    if threads is not None and name != "cpu":
        raise InputError(f"threads {threads!r} for the {name} backend; only the cpu backend has a choice of threads")
    try:
        backend = import_module(f"cnnsim.backends.{name}.backend").BACKEND  # only the one that is used
    except ModuleNotFoundError as error:
        if error.name != "pyopencl":
            raise
        raise InputError(f"the opencl backend needs pyopencl: {install_line('opencl')}") from error
    given = [value for value in (device, threads) if value is not None]
    found: Backend = backend(dtype, *given)
    return found


def chosen(backend: str | Backend, dtype: DTypeLike | None = None, threads: int | None = None) -> Backend:
    """Return the backend of a name, as `get`, or the backend that is given: its numbers and threads are its own.

    Raises:
        InputError: as `get`; something else, or another dtype or threads than those of the backend that is given.
    """
    if isinstance(backend, str):
        return get(backend, dtype, threads=threads)
    if not hasattr(backend, "transient"):
        raise InputError(f"backend {backend!r}; one of {', '.join(NAMES)}, or a backend, wanted")
    if threads is not None or (dtype is not None and parse_dtype(dtype) != backend.dtype):
        given = f"dtype {dtype!r}" if threads is None else f"threads {threads!r}"
        raise InputError(
            f"{given} with a backend of {backend.dtype} that is made already; its name, or neither, wanted"
        )
    return backend


def in_float64(backend: Backend) -> Backend:
    """Return a backend like this one that computes in float64, or this one if its device cannot."""
    if backend.dtype == "float64":
        return backend
    try:
        return get(backend.name, "float64", getattr(backend, "chosen_device", None))
    except InputError:
        return backend
