"""Values of the front door go to other processes, and are compared, without surprises."""

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import cnnsim

GREY = np.full((4, 5), 0.3)


def test_an_error_with_its_result_goes_to_another_process() -> None:
    """Else a pool of processes waits for ever for an answer that it cannot read."""
    with pytest.raises(cnnsim.NotSettledError) as caught:
        cnnsim.run_transient(cnnsim.Template([[0, 1, 0], [1, 2, 1], [0, 1, 0]]), state=GREY, limit=0.1)
    there = pickle.loads(pickle.dumps(caught.value))
    assert (type(there), str(there)) == (cnnsim.NotSettledError, str(caught.value))
    assert np.array_equal(there.result.x, caught.value.result.x)


def test_sequences_are_compared_as_other_values_with_planes() -> None:
    frames = cnnsim.Frames([GREY, GREY], 1.0)
    assert frames == frames
    assert frames != cnnsim.Frames([GREY, GREY], 1.0)
    assert len({frames, frames}) == 1


def test_a_machine_says_what_it_keeps() -> None:
    machine = cnnsim.UniversalMachine(dtype="float64")
    assert repr(machine) == "UniversalMachine(cpu, float64)"
    machine.run(cnnsim.load_program("motion-detection"), frame=GREY)
    assert repr(machine) == "UniversalMachine(cpu, float64, planes of motion-detection)"


@pytest.mark.parametrize("copied", [pickle.dumps, copy.deepcopy])
def test_a_machine_refuses_to_be_copied(copied: Any) -> None:
    with pytest.raises(TypeError, match="one made in each process wanted"):
        copied(cnnsim.UniversalMachine())
