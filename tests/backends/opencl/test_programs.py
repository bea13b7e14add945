"""Frames of programs on both families of kernels end as on the reference."""

import numpy as np
import pytest

from cnnsim import UniversalMachine, load_program
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", ["opening", "contact-blob", "slip-front", "event-code"])
def test_frames_of_a_program(name: str, family: Family) -> None:
    backend, program, rng = OpenCLBackend("float32", family=family), load_program(name), np.random.default_rng(1)
    for shape in ((8, 8), (50, 8, 8)):
        planes = {plane: np.where(rng.random(shape) < 0.5, 0.3, -0.3) for plane in program.inputs}
        ours, law = UniversalMachine(backend), UniversalMachine("reference")
        for _ in range(2):
            found, wanted = ours.run(program, **planes), law.run(program, **planes)
            for output, value in wanted.items():
                np.testing.assert_array_equal(found[output], value, err_msg=output)
