"""Values of the front door go to other processes, and are compared, without surprises."""

import copy
import pickle
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import cnnsim
from tests.kits.backends import Variant, build, variants

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


def there_and_back(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize(
    "backend", [one for one in variants() if one.dtype == "float32" or one.name == "reference"], ids=str
)
@pytest.mark.parametrize("copied", [there_and_back, copy.deepcopy])
def test_a_machine_goes_to_another_process_with_what_its_programs_keep(backend: Variant, copied: Any) -> None:
    """Its program comes along, or is loaded there anew: it is the same by what it does."""
    first, second = np.full((4, 5), -1.0), np.full((4, 5), -1.0)
    first[1:3, 2], second[1:3, 3] = 1, 1
    program = cnnsim.load_program("motion-detection")
    machine = cnnsim.UniversalMachine(build(*backend))
    machine.run(program, frame=first)
    twins = [copied((machine, program)), (copied(machine), cnnsim.load_program("motion-detection"))]
    wanted, fresh = (
        machine.run(program, frame=second),
        cnnsim.UniversalMachine(build(*backend)).run(program, frame=second),
    )
    assert any(not np.array_equal(wanted[name], fresh[name]) for name in wanted)  # else nothing need be kept
    for twin, its in twins:
        assert repr(twin) == repr(machine)
        assert twin.kept(its).keys() == program.keep.keys()
        got = twin.run(its, frame=second)
        assert got.keys() == wanted.keys()
        assert all(np.array_equal(got[name], wanted[name]) for name in wanted)
        twin.reset()
        assert twin.kept(its) == {}
    assert copied(machine).kept(cnnsim.load_program("skeleton")) == {}


def test_a_machine_takes_its_choices_along(tmp_path: Any) -> None:
    one = there_and_back(cnnsim.UniversalMachine(dtype="float64", threads=1))
    assert there_and_back(one).__reduce__()[1][0].__reduce__()[1] == ("float64", 1)
    if find_spec("zarr") is None:
        pytest.skip("no zarr")
    large = cnnsim.UniversalMachine(engine="processes", store=tmp_path / "store")
    assert there_and_back(large).__reduce__()[1][1:3] == ("processes", tmp_path / "store")
    large._kept[cnnsim.load_program("motion-detection")] = "planes on the disk"  # type: ignore[assignment]
    with pytest.raises(cnnsim.InputError, match="keeps planes of motion-detection on the disk"):
        pickle.dumps(large)
