"""Launches, waits, buffers and bytes of transients and programs: exact numbers, which need no GPU."""

import numpy as np

from cnnsim import UniversalMachine, load_program
from tests.kits.opencl import OpenCLBackend, counted


def test_a_program_of_two_neighbourhoods_waits_once() -> None:
    backend, picture = OpenCLBackend("float32"), np.random.default_rng(1).random((8, 70)) > 0.5
    program, machine = load_program("opening"), UniversalMachine(backend)
    counts = counted(backend, lambda: machine.run(program, **{program.inputs[0]: picture}))
    words = 8 * 2 * 8
    assert (counts.launches, counts.waits, counts.buffers) == (2, 1, 3)
    assert (counts.to_device, counts.from_device) == (words, words)
