"""Variants of tests that take long: `make test` leaves them out, `make test-all` runs them.

A module or test that is long as a whole has the marker itself.
"""

SLOW = {
    "backends/": ("opencl-cpu-float64",),
    "backends/conformance/test_programs.py": ("3-on an engine", "0.5-on an engine", "sign-on an engine"),
    "backends/opencl/test_library.py": ("gpu",),
    "backends/opencl/test_patch.py": ("as_on_the_reference[zero-flux]", "as_on_the_reference[periodic]"),
    "backends/opencl/test_transient.py": ("of_the_reference[gpu]", "rows_that_are_moved_up_often"),
    "backends/test_slices.py": ("float64",),
    "hard_cases/": ("opencl-cpu-float32-located",),
    "cnnsim/planning/test_stability.py": ("[2-0-3-30.0-A]", "[1-0-2-30.0-A]"),
    "cnnsim/supersteps/test_devices.py": ("device_of_its_own",),
    "cnnsim/supersteps/test_program_stops.py": ("everything",),
    "cnnsim/supersteps/test_stores.py": ("any_number_of_workers",),
    "cnnsim/support/test_compiled_loops.py": ("[text-", "[empty-"),
    "cnnsim/support/test_notices.py": ("a_terminal_shows_where",),
    "cnnsim/theory/test_wave_time.py": ("one_way_templates[boundary1]", "one_way_templates[boundary2]"),
    "fuzz/test_broken_files.py": ("hostile",),
    "fuzz/test_cable.py": ("loses_nothing",),
    "project/test_commands.py": (
        "detectors-measured",
        "how-to/thresholds",
        "how-to/convert",
        "how-to/learn",
        "bring-your-own",
        "[tactile score]",
    ),
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
