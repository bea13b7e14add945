"""The OpenCL backend for its own tests; modules that import this are skipped if there is no device."""

import pytest

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl.backend import OpenCLBackend  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.device.devices import Family, all_devices  # noqa: E402

if not all_devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)

FAMILIES: tuple[Family, ...] = ("cpu", "gpu")

__all__ = ["FAMILIES", "Family", "OpenCLBackend", "cl"]
