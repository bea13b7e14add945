"""All backends in all their dtypes; OpenCL with both its families of kernels."""

from functools import cache
from importlib.util import find_spec
from typing import Any, NamedTuple, cast

import pytest

from cnnsim import backends
from cnnsim.backends.base import Backend

DTYPES = {"reference": ("float64",)}
"""Of backends that do not compute in both float32 and float64."""


def _families() -> tuple[str, ...]:
    """Return the families of OpenCL kernels that the device can build: a GPU only its own."""
    if find_spec("pyopencl") is None:
        return ("cpu", "gpu")
    from cnnsim.backends.opencl.device.devices import all_devices, choose_device, family_of

    return ("gpu",) if all_devices() and family_of(choose_device()) == "gpu" else ("cpu", "gpu")


FAMILIES = {"opencl": _families()}
"""Of backends with several families of kernels."""

SECOND = ("float32",)
"""Dtypes in which a second family is tried: its text is the same in all, and each build takes a second."""

COMPILING = ("opencl",)
"""Backends that compile every network for itself, for seconds."""

TOLERANCE = {"float32": 1e-5, "float64": 1e-12}
"""How far a state may be from the reference's, as a part of the largest state that the network can reach."""

REFERENCE = backends.get("reference")


class Variant(NamedTuple):
    """One of the backends under test."""

    name: str
    family: str | None
    dtype: str

    def __str__(self) -> str:
        return "-".join(filter(None, self))


def variants(*names: str) -> list[Variant]:
    """All of them, or those of the backends with these names."""
    return [
        Variant(name, family, dtype)
        for name in names or backends.NAMES
        for number, family in enumerate(FAMILIES.get(name, (None,)))
        for dtype in (SECOND if number else DTYPES.get(name, ("float32", "float64")))
    ]


@cache
def build(name: str, family: str | None, dtype: Any) -> Backend:
    """One backend for all tests; they are skipped where it cannot be had."""
    if name != "opencl":
        return backends.get(name, dtype)
    pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")
    from cnnsim.backends.opencl.backend import OpenCLBackend
    from cnnsim.backends.opencl.device.devices import all_devices, choose_device, has_float64, title

    if not all_devices():
        pytest.skip("there is no OpenCL device")
    if dtype == "float64" and not has_float64(choose_device()):
        pytest.skip(f"{title(choose_device())} has no float64")
    return OpenCLBackend(dtype, family=cast(Any, family))
