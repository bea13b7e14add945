"""The OpenCL backend for its own tests; modules that import this are skipped if there is no device."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl import backend as opencl  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.device.counts import Counts  # noqa: E402
from cnnsim.backends.opencl.device.devices import Family, all_devices, choose_device, family_of  # noqa: E402

if not all_devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)

FAMILIES: tuple[Family, ...] = ("gpu",) if family_of(choose_device()) == "gpu" else ("cpu", "gpu")
"""The families of kernels that the device can build: those for CPUs use builtins that compilers for GPUs lack."""


class OpenCLBackend(opencl.OpenCLBackend):
    """The backend; a test is skipped where the device cannot build its family of kernels."""

    def __init__(self, dtype: Any = None, device: Any = None, family: Family | None = None) -> None:
        if family is not None and family not in FAMILIES:
            pytest.skip(f"the device does not build the kernels for a {family}")
        super().__init__(dtype, device, family)


__all__ = ["FAMILIES", "Family", "OpenCLBackend", "cl", "counted"]


def counted(backend: OpenCLBackend, work: Callable[[], object]) -> Counts:
    """Do some work a second time, when everything is compiled and in tables, and return its counts."""
    work()
    backend._context.counts = Counts()
    work()
    return replace(backend._context.counts)
