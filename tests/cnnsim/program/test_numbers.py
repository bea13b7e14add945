"""Numbers on wires, in programs."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim import InputError
from tests.kits.program import load
from tests.kits.program_cases import BACKENDS, machine

COUNTING = """
name = "counting"
lam = ["level"]
llm = ["picture", "state"]
wire = ["black", "twice", "rounds", "few"]
inputs = ["picture"]
outputs = ["level", "state", "black", "twice", "rounds", "few"]
parameters = { times = 3, many = 5 }
step = [
  { wire = "count", of = "picture", to = "black" },
  { number = "multiply", of = ["black", 2], to = "twice" },
  { number = "less", of = ["black", "many"], to = "few" },
  { fill = "twice", to = "level" },
  { fill = 0, to = "rounds" },
  { repeat = "times", do = [ { number = "add", of = ["rounds", 1], to = "rounds" } ] },
  { template = "connected-components-horizontal", state = "picture", to = "state" },
]
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_numbers_of_wires(backend: str, tmp_path: Path) -> None:
    """Arithmetic on registers, a plane filled from one, rounds from a parameter; a state plane called picture."""
    plane = np.array([[1, 1, 0, 1]], dtype=bool)
    out = machine(backend).run(load(tmp_path, COUNTING, parameters={"times": 7}), picture=plane)
    assert (out["black"], out["twice"], out["rounds"], out["few"]) == (3, 6, 7, 1)
    assert out["level"].tolist() == [[6, 6, 6, 6]]
    assert out["state"].tolist() == [[False, True, False, True]]
    assert machine(backend).run(load(tmp_path, COUNTING, parameters={"many": 3}), picture=plane)["few"] == 0


@pytest.mark.parametrize(("old", "new", "message"), [
    ('number = "add"', 'number = "divide"', "number function 'divide'; known are add, subtract, multiply, less"),
    ('["rounds", 1]', '["rounds"]', "of 1 numbers; two wanted"),
    ('["rounds", 1]', '["rounds", 1.5]', "1.5; a whole number wanted"),
    ('["rounds", 1]', '["rounds", "picture"]', "'picture' is in llm; wire wanted"),
    ('{ fill = 0, to = "rounds" },', "", "'rounds' is read before anything has been written"),
    ('fill = "twice"', 'fill = "rounds"', "'rounds' is read before anything has been written"),
    ('{ fill = 0,', "{ fill = 0.5,", "0.5; a whole number wanted"),
    ('repeat = "times"', 'repeat = "time"', "no parameter 'time'; defined are times, many"),
    ("times = 3", "times = 2.5", "times 2.5; a whole number from 1 to 1000000 wanted"),
    ("times = 3", "times = 0", "times 0.0; a whole number from 1 to 1000000 wanted"),
])  # fmt: skip
def test_wrong_numbers_are_refused(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in COUNTING
    with pytest.raises(InputError, match=message):
        load(tmp_path, COUNTING.replace(old, new))


POWERS = """
name = "powers"
llm = ["picture"]
wire = ["n"]
inputs = ["picture"]
outputs = ["n"]
parameters = { rounds = 62 }
step = [
  { wire = "any", of = "picture", to = "n" },
  { repeat = "rounds", do = [ { number = "multiply", of = ["n", 2], to = "n" } ] },
  { number = "add", of = ["n", 0], to = "n" },
  { number = "add", of = ["n", 0], to = "n" },
]
"""


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("grids", [(), (2,)], ids=["one grid", "a batch"])
def test_registers_are_exact_up_to_their_size_and_no_further(
    backend: str, grids: tuple[int, ...], tmp_path: Path
) -> None:
    plane = np.ones((*grids, 2, 3), bool)
    assert np.all(machine(backend).run(load(tmp_path, POWERS), picture=plane)["n"] == 2**62)
    with pytest.raises(InputError, match=r"multiply\): comes to 9.223e\+18; registers hold 9.223e\+18 at most"):
        machine(backend).run(load(tmp_path, POWERS, parameters={"rounds": 63}), picture=plane)


def test_a_number_beyond_those_that_floats_count_is_refused(tmp_path: Path) -> None:
    text = COUNTING.replace('["rounds", 1]', '["rounds", 1e308]')
    with pytest.raises(InputError, match=r"1e\+308; .* at most wanted"):
        load(tmp_path, text)
