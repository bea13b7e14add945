"""Variants of tests that take long: `make test` leaves them out, `make test-all` runs them.

A module or test that is long as a whole has the marker itself.
"""

SLOW = {
    "backends/": ("opencl-cpu-float64",),
    "backends/conformance/test_cases.py": ("opencl-gpu",),
    "backends/conformance/test_programs.py": ("3-on an engine", "0.5-on an engine", "sign-on an engine"),
    "backends/conformance/test_recording.py": ("opencl-gpu",),
    "backends/conformance/test_schemes.py": ("opencl-gpu",),
    "backends/conformance/test_terms.py": ("opencl-gpu", "table_goes_on", "table_alone"),
    "backends/conformance/test_transient.py": (
        "hard_sizes[opencl",
        "given_durations[opencl-gpu",
        "settle_or_not[opencl-gpu",
    ),
    "backends/opencl/test_library.py": ("gpu",),
    "backends/opencl/test_patch.py": ("as_on_the_reference[zero-flux]", "as_on_the_reference[fixed"),
    "backends/opencl/test_sleep.py": ("where_a_wave_comes",),
    "backends/opencl/test_transient.py": ("steps_a_launch",),
    "backends/test_slices.py": ("float64", "opencl-gpu"),
    "hard_cases/": ("opencl-cpu-float32-located", "opencl-cpu-float64-located"),
    "cnnsim/library/test_catalogue.py": ("opencl",),
    "cnnsim/network/test_discrete_time.py": ("one_step_is_enough[cpu]",),
    "cnnsim/network/test_frames.py": ("followed_exactly[cpu]",),
    "cnnsim/planning/test_stability.py": ("[2-0-3-30.0-A]", "[1-0-2-30.0-A]", "grows_fast"),
    "cnnsim/program/test_library.py": ("opencl",),
    "cnnsim/program/test_pictures.py": ("opencl", "halftone_and_back[reference]"),
    "cnnsim/prototyping/design/test_decompose.py": ("more_templates", "hard_rules"),
    "cnnsim/supersteps/test_devices.py": ("device_of_its_own",),
    "cnnsim/supersteps/test_program_stops.py": ("everything",),
    "cnnsim/supersteps/test_programs.py": ("every_kind_of_step", "own_bits[float64]", "the_dense_bits[onset-wave]"),
    "cnnsim/supersteps/test_stores.py": ("any_number_of_workers",),
    "cnnsim/support/test_notices.py": ("a_terminal_shows_where",),
    "cnnsim/test_memory.py": ("command_line[rk4]",),
    "cnnsim/theory/test_wave_time.py": ("one_way_templates[boundary1]", "one_way_templates[boundary2]"),
    "fuzz/test_broken_files.py": ("hostile",),
    "fuzz/test_cable.py": ("loses_nothing", "false_frames_over_a_bad_cable[papillarray"),
    "project/test_commands.py": (
        "detectors-measured",
        "how-to/thresholds",
        "how-to/convert",
        "how-to/learn",
        "bring-your-own",
        "[tactile score]",
        "[tactile learn]",
        "[tactile run]",
    ),
    "project/test_examples.py": ("a_locking_element",),
    "project/test_paper.py": ("",),
    "project/test_site.py": ("teach-an-event",),
    "project/test_wheel.py": ("",),
    "tactile/bump/": ("",),
    "tactile/calibration/": ("",),
    "tactile/cli/test_live.py": ("byte[native-auto]", "byte[reskin"),
    "tactile/events/test_backends.py": ("opencl",),
    "tactile/events/test_many_taxels.py": ("128-150", "32-400", "noise_makes_no_event"),
    "tactile/events/test_rough_surfaces.py": ("intermittent",),
    "tactile/inverse/test_unsound.py": ("deviations_cover",),
    "tactile/output/test_unread.py": ("",),
    "tactile/simulator/contacts/test_sliding_ends.py": ("one_straight_way",),
    "tactile/simulator/effects/test_combined.py": ("circles_of_many",),
}
"""Parts of the ids of long tests, and words of which the name of the test or its variant has one."""


def is_slow(test: str) -> bool:
    """Return whether a test with this id takes long."""
    name = test.partition("::")[2]
    return any(where in test and any(word in name for word in words) for where, words in SLOW.items())
