"""The OpenCL backend for its own tests; modules that import this are skipped if there is no device."""

from collections.abc import Callable
from dataclasses import replace

import pytest

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl.backend import OpenCLBackend  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.device.context import Counts  # noqa: E402
from cnnsim.backends.opencl.device.devices import Family, all_devices  # noqa: E402

if not all_devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)

FAMILIES: tuple[Family, ...] = ("cpu", "gpu")

__all__ = ["FAMILIES", "Family", "OpenCLBackend", "cl", "counted"]


def counted(backend: OpenCLBackend, work: Callable[[], object]) -> Counts:
    """Do some work a second time, when everything is compiled and in tables, and return its counts."""
    work()
    backend._context.counts = Counts()
    work()
    return replace(backend._context.counts)
