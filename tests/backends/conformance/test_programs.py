"""Programs on a backend: batches, and planes that come from one verb and go into the next."""

import numpy as np

from cnnsim import UniversalMachine, load_program
from cnnsim.backends.base import Backend


def test_a_program_on_a_batch_is_the_program_on_each_grid(backend: Backend) -> None:
    program = load_program("opening")
    pictures = np.where(np.random.default_rng(2).random((6, 30, 80)) > 0.4, 1.0, -1.0)
    name = program.inputs[0]
    batch = UniversalMachine(backend).run(program, **{name: pictures})
    for i, picture in enumerate(pictures):
        alone = UniversalMachine(backend).run(program, **{name: picture})
        for output, value in alone.items():
            np.testing.assert_array_equal(batch[output][i], value)
