"""Where transients are computed. `get` is the only place that knows the names."""

from numpy.typing import DTypeLike

from cnnsim.backends.base import Backend
from cnnsim.support.errors import InputError

NAMES = ("reference", "cpu", "opencl")
OPENCL_CURE = 'pip install "cellular-wave-touch[opencl]"'


def get(name: str = "cpu", dtype: DTypeLike | None = None, device: str | None = None) -> Backend:
    """Return the backend called ``name``, working in ``dtype`` (its own default if None).

    ``device`` is a number or a part of a name, for backends that have a choice.

    Raises:
        InputError: no such backend, one that is not installed, or one that cannot work in this dtype.
    """
    if device is not None and name != "opencl":
        raise InputError(f"device {device!r} for the {name} backend; only the opencl backend has a choice of devices")
    if name == "reference":
        from cnnsim.backends.reference.backend import ReferenceBackend

        return ReferenceBackend(dtype)
    if name == "cpu":
        from cnnsim.backends.cpu.backend import CpuBackend

        return CpuBackend(dtype)
    if name == "opencl":
        try:
            from cnnsim.backends.opencl.backend import OpenCLBackend
        except ModuleNotFoundError as error:
            if error.name != "pyopencl":
                raise
            raise InputError(f"the opencl backend needs pyopencl: {OPENCL_CURE}") from error
        return OpenCLBackend(dtype, device)
    raise InputError(f"backend {name!r}; known are {', '.join(NAMES)}")
