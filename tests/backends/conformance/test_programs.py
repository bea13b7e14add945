"""Programs on a backend: batches, and planes that come from one verb and go into the next."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import ZERO_FLUX, InputError, Program, Template, UniversalMachine, load_program, run_transient
from cnnsim.backends.base import Backend
from cnnsim.network import Cell, Characteristic
from cnnsim.network.table import lines
from cnnsim.operations.routine import Routine
from cnnsim.program.program import TemplateStep
from cnnsim.supersteps.engine import Engine
from tests.kits.program import load


def test_a_program_on_a_batch_is_the_program_on_each_grid(backend: Backend) -> None:
    program = load_program("opening")
    pictures = np.where(np.random.default_rng(2).random((6, 30, 80)) > 0.4, 1.0, -1.0)
    name = program.inputs[0]
    batch = UniversalMachine(backend).run(program, **{name: pictures})
    for i, picture in enumerate(pictures):
        alone = UniversalMachine(backend).run(program, **{name: picture})
        for output, value in alone.items():
            np.testing.assert_array_equal(batch[output][i], value)


STRAIGHT = """
name = "straight"
lam = ["a", "b", "half"]
llm = ["p", "q", "r", "kept"]
wire = ["n", "m", "many"]
inputs = ["a", "p"]
outputs = ["q", "r", "b", "n", "m", "many", "kept"]
keep = { kept = -1 }
step = [
  { template = "near", input = "p", state = 0, to = "q" },
  { template = "on", input = "a", state = "kept", to = "kept" },
  { template = "mean", input = "a", state = 0.25, to = "b" },
  { template = "mean", input = "p", state = "p", to = "half" },
  { logic = "xor", of = ["q", "kept"], to = "r" },
  { copy = "half", to = "p" },
  { wire = "count", of = "r", to = "n" },
  { wire = "all", of = "p", to = "m" },
  { number = "multiply", of = ["n", 100000], to = "many" },
  { number = "multiply", of = ["many", "many"], to = "many" },
  { number = "multiply", of = ["many", SQUARED], to = "many" },
  { number = "less", of = ["m", 1], to = "m" },
  { fill = "m", to = "q" },
  { logic = "p-or-not-q", of = ["q", "r"], to = "q" },
]
[templates]
near = { A = [[1]], B = [[1, 1, 1], [1, 0, 1], [1, 1, 1]], z = 7, boundary = { fixed = -1 } }
on = { A = [[2]], B = [[24]], z = -5 }
mean = { A = [[0]], B = [[0.1, 0.2, 0.1], [0.2, 0.3, 0.2], [0.1, 0.2, 0.1]], boundary = "periodic" }
"""


class OneByOne:
    """A backend that does every step alone."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend

    def __getattr__(self, name: str) -> Any:
        return getattr(self._backend, name)

    def prepared(self, _routine: Routine) -> None:
        return None


@pytest.mark.parametrize("factor", ["1", "many"])
def test_steps_at_one_go_are_the_steps_one_by_one(backend: Backend, tmp_path: Path, factor: str) -> None:
    """Bit for bit, over several frames; a number beyond 64 bits gives the same error."""
    program = load(tmp_path, STRAIGHT.replace("SQUARED", '"many"' if factor == "many" else factor))
    rng = np.random.default_rng(5)
    whole, steps = UniversalMachine(backend), UniversalMachine(OneByOne(backend))
    said = False
    for shape in ((8, 8), (1, 70), (3, 2)):
        for _ in range(3):
            given = {"a": rng.uniform(-1, 1, shape), "p": rng.random(shape) < 0.4}
            ours, theirs = (_outcome(machine, program, given) for machine in (whole, steps))
            assert ours.get("said") == theirs.get("said")
            said |= "said" in theirs
            for name, value in theirs.items():
                np.testing.assert_array_equal(ours[name], value, err_msg=name, strict=isinstance(value, np.ndarray))
                assert type(ours[name]) is type(value)
            if "said" not in theirs:
                np.testing.assert_array_equal(whole.kept(program)["kept"], steps.kept(program)["kept"])
    assert said == (factor == "many")


def _outcome(machine: UniversalMachine, program: Program, given: dict[str, Any]) -> dict[str, Any]:
    try:
        return machine.run(program, **given)
    except InputError as error:
        return {"said": str(error)}


def test_a_value_that_is_not_finite_is_told_by_its_step(backend: Backend, tmp_path: Path) -> None:
    program = load(tmp_path, STRAIGHT.replace("SQUARED", "1"))
    a = np.zeros((4, 4))
    a[1, 2] = np.nan
    with pytest.raises(InputError, match=r"step 2.*cell \(1, 2\)"):
        UniversalMachine(backend).run(program, a=a, p=a > 0)


SOFT = [
    Characteristic("tanh", 0.5), Characteristic(slope=3), Characteristic("sign"),
    Characteristic("table", table=lines((-1, -1), (0.5, -0.5), (1, 1))),
]  # fmt: skip


@pytest.mark.parametrize("on_disk", [False, True], ids=["here", "on an engine"])
@pytest.mark.parametrize("f", SOFT, ids=str)
def test_a_plane_takes_what_the_characteristic_makes_of_the_state(
    backend: Backend, f: Characteristic, on_disk: bool
) -> None:
    if on_disk and backend.name == "opencl":
        pytest.skip("a task of an engine makes a backend of its own, which is tried where it is cheap")
    cell, x = Cell("chua-yang", f), np.random.default_rng(7).uniform(-1, 1, (6, 9))
    template = Template([[0.2]], [[1.0]], 0.1)
    steps = tuple(TemplateStep(to, template, ZERO_FLUX, 3.0, "u", 0.0, None, None, to, cell) for to in ("y", "black"))
    program = Program("soft", "", {"u": "lam", "y": "lam", "black": "llm"}, ("u",), ("y", "black"), {}, steps)
    machine = UniversalMachine(backend, engine=Engine(workers=1, side=4) if on_disk else None)
    found = machine.run(program, u=x)
    end = run_transient(template, state=0 * x, input=x, cell=cell, duration=3.0, backend=backend)
    assert np.array_equal(found["y"], f(end.x))
    assert np.array_equal(found["black"], f(end.x) > 0)
    assert not np.allclose(f(end.x), end.x.clip(-1, 1), atol=0.01)
