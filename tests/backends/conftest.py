"""The fixture `backend`: every backend in turn. One that stands in `cnnsim.backends.NAMES` is one of them."""

from typing import Any

import pytest

from cnnsim.backends.base import Backend
from tests.kits.backends import TOLERANCE, build, variants

HASTY = {
    "backends/conformance/": ("opencl-cpu-float64", "opencl-gpu-float32"),
    "backends/conformance/test_cases.py": ("opencl",),
    "backends/conformance/test_recording.py": ("opencl",),
    "backends/conformance/test_transient.py::test_hard_sizes": ("rk4",),
    "backends/conformance/test_schemes.py": ("opencl",),
    "backends/conformance/test_settled.py": ("opencl",),
    "backends/opencl/test_library.py": ("gpu",),
    "backends/opencl/test_memory.py": ("float64",),
    "backends/opencl/test_stages.py": ("gpu",),
    "backends/test_slices.py::test_slices_change_no_bit": ("gpu",),
    "backends/opencl/test_transient.py": ("gpu", "periodic", "fixed"),
    "backends/opencl/test_sleep.py": ("zero-flux", "periodic"),
}
"""Variants whose kernels are built without the optimiser, which takes most of a small test's time: as float32 for CPUs
random transients, terms and programs are optimised, and of tests at several boundaries the first one."""


@pytest.fixture(autouse=True)
def second_variants_are_built_in_haste(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    test, name = request.node.nodeid, request.node.name
    if not any(where in test and any(variant in name for variant in those) for where, those in HASTY.items()):
        return
    cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")
    build = cl.Program.build

    def hasty(program: Any, options: list[str], **others: Any) -> Any:
        return build(program, [*options, "-cl-opt-disable"], **others)

    monkeypatch.setattr(cl.Program, "build", hasty)


@pytest.fixture(scope="session", params=variants(), ids=str)
def backend(request: pytest.FixtureRequest) -> Backend:
    return build(*request.param)


@pytest.fixture(scope="session")
def tolerance(backend: Backend) -> float:
    return TOLERANCE[backend.dtype.name]
