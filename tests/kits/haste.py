"""Which tests build OpenCL kernels with the device's optimiser; the others build them without it.

The optimiser takes two thirds of the time of most kernel tests, because it runs for every template, boundary and dtype.
Its effects (undefined behaviour, other rounding) show in tests that cover all kernels, schemes and kinds of terms;
library templates and hard cases are tested without it. Kernels that run longer than it takes are optimised, too.
"""

from collections.abc import Mapping

OPTIMISED = {
    "backends/conformance/": ("opencl-cpu-float32",),
    "backends/opencl/": ("",),
    "backends/test_slices.py": ("heard",),
}
"""Tests with the optimiser: a part of their ids, and words of which the name of the test or variant has one."""

HASTY = {
    "backends/conformance/test_cases.py": ("opencl",),
    "backends/conformance/test_cellwise.py": ("opencl",),
    "backends/conformance/test_discrete_time.py": ("batch",),
    "backends/conformance/test_not_finite.py": ("opencl",),
    "backends/conformance/test_programs.py": ("opencl",),
    "backends/conformance/test_recording.py": ("opencl",),
    "backends/conformance/test_transient.py": ("rk4", "settle_or_not", "batch", "stay_as_they_are"),
    "backends/conformance/test_schemes.py": ("opencl",),
    "backends/conformance/test_settled.py": ("opencl",),
    "backends/opencl/test_library.py": ("gpu",),
    "backends/opencl/test_memory.py": ("",),
    "backends/opencl/test_transient.py": ("gpu", "periodic", "fixed"),
    "backends/opencl/test_sleep.py": ("hole-filler-zero-flux", "hole-filler-periodic"),
}
"""Exceptions that are built without the optimiser; of tests with several boundaries the first is optimised."""


def in_haste(test: str) -> bool:
    """Return whether kernels are built without the optimiser in a test with this id."""
    return not _among(OPTIMISED, test) or _among(HASTY, test)


def _among(table: Mapping[str, tuple[str, ...]], test: str) -> bool:
    name = test.partition("::")[2]
    return any(where in test and any(word in name for word in words) for where, words in table.items())
