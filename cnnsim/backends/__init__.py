"""Backends, which compute transients: `get` returns one by its name.

From `cnnsim.run_transient` to the innermost loop are five calls at most: the backend's ``transient``, the time loop
(`driver.run`), the stepper's ``advance``, on the CPU the compiled loop over tiles, and a tile; with OpenCL the launch
of a kernel. Euler steps of a linear template on the CPU: ``transient``, `EulerTiles.run`, `dense` or `sleeping` with
the compiled time loop, a tile, its rows.
"""

from importlib import import_module

from numpy.typing import DTypeLike

from cnnsim.backends.base import Backend, parse_dtype
from cnnsim.support import InputError
from cnnsim.support.errors import not_known
from cnnsim.support.extras import install_line

NAMES = ("reference", "cpu", "opencl")
"""Each is a folder of this package; ``BACKEND`` of its module ``backend`` is the class."""


def get(
    name: str = "cpu", dtype: DTypeLike | None = None, device: str | None = None, threads: int | None = None
) -> Backend:
    """Return the backend called ``name`` for numbers of ``dtype`` (its own default if None).

    ``device`` of the opencl backend is a number or a part of a name; ``threads`` of the cpu backend are from 1
    to the number of cores, None for all cores.

    Raises:
        InputError: no such backend, or it is not installed, or it has no such dtype.
    """
    if name not in NAMES:
        if name.lower() in ("gpu", "cuda"):  # by its letters the cpu would be the nearest
            raise InputError(f"backend {name!r}; known are {', '.join(NAMES)}; did you mean 'opencl'?")
        raise not_known("backend", name, NAMES)
    if device is not None and name != "opencl":
        raise InputError(f"device {device!r} for the {name} backend; only the opencl backend takes a device")
    if threads is not None and name != "cpu":
        raise InputError(f"threads {threads!r} for the {name} backend; only the cpu backend takes threads")
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
    """Return the backend of a name, as `get`, or a given backend itself, which has its own dtype and threads.

    Raises:
        InputError: as `get`; not a backend; another dtype or threads for a given backend.
    """
    if isinstance(backend, str):
        return get(backend, dtype, threads=threads)
    if not hasattr(backend, "transient"):
        raise InputError(f"backend {backend!r}; one of {', '.join(NAMES)}, or a backend, wanted")
    if threads is not None or (dtype is not None and parse_dtype(dtype) != backend.dtype):
        given = f"dtype {dtype!r}" if threads is None else f"threads {threads!r}"
        raise InputError(f"{given} with an existing backend of {backend.dtype}; a backend's name, or neither, wanted")
    return backend


def in_float64(backend: Backend) -> Backend:
    """Return a backend like this one that computes in float64, or this one if its device cannot."""
    if backend.dtype == "float64":
        return backend
    try:
        return get(backend.name, "float64", getattr(backend, "chosen_device", None))
    except InputError:
        return backend
