"""Launches, waits, buffers and bytes of programs: exact numbers, which need no GPU."""

import numpy as np
import pytest

from cnnsim import UniversalMachine, load_program
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend, counted

COUNTS = {"opening": (1, 1, 2), "contact-blob": (1, 1, 2), "slip-front": (1, 1, 4), "event-code": (1, 1, 4)}
"""Launches, waits of the host, and buffers, those of the inputs included."""


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", COUNTS)
def test_a_frame_of_a_program_is_one_launch_and_one_wait(name: str, family: Family) -> None:
    backend, program, rng = OpenCLBackend("float32", family=family), load_program(name), np.random.default_rng(1)
    for shape in ((8, 8), (50, 8, 8)):
        planes = {plane: np.where(rng.random(shape) < 0.5, 0.3, -0.3) for plane in program.inputs}
        ours, law = UniversalMachine(backend), UniversalMachine("reference")
        for _ in range(2):
            found, wanted = ours.run(program, **planes), law.run(program, **planes)
            for output, value in wanted.items():
                np.testing.assert_array_equal(found[output], value, err_msg=output)
        counts = counted(backend, lambda planes=planes, ours=ours: ours.run(program, **planes))  # type: ignore[misc]
        assert (counts.launches, counts.waits, counts.buffers) == COUNTS[name]
        given = [8 * planes[p].shape[-2] if program.memory[p] == "llm" else 4 * 64 for p in program.inputs]
        assert counts.to_device == sum(given) * (1 if len(shape) == 2 else shape[0])
