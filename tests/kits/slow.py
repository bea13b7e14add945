"""Variants of tests that take long: `make test` leaves them out, `make test-all` runs them.

A module or test that is long as a whole has the marker itself.
"""

SLOW = {
    "backends/": ("opencl-cpu-float64",),
    "backends/opencl/test_library.py": ("gpu",),
    "backends/test_slices.py": ("float64",),
    "hard_cases/": ("opencl-cpu-float32-located",),
    "cnnsim/supersteps/test_program_stops.py": ("everything",),
    "cnnsim/supersteps/test_stores.py": ("any_number_of_workers",),
    "fuzz/test_broken_files.py": ("hostile",),
    "fuzz/test_cable.py": ("loses_nothing",),
    "project/test_commands.py": ("detectors-measured", "how-to/thresholds", "how-to/convert"),
    "project/test_paper.py": ("",),
    "project/test_wheel.py": ("",),
    "tactile/bump/": ("",),
    "tactile/calibration/": ("",),
    "tactile/output/test_unread.py": ("",),
    "tactile/events/test_backends.py": ("opencl",),
    "tactile/events/test_many_taxels.py": ("128-150", "32-400"),
}
"""Parts of the ids of long tests, and words of which the name of the test or its variant has one."""


def is_slow(test: str) -> bool:
    """Return whether a test with this id takes long."""
    name = test.partition("::")[2]
    return any(where in test and any(word in name for word in words) for where, words in SLOW.items())
