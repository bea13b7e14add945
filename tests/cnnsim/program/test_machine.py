"""Programs: every kind of step runs on every backend."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from cnnsim import InputError, Template
from cnnsim.backends import NAMES
from cnnsim.operations.logic import FUNCTIONS, function_number
from cnnsim.program.machine import UniversalMachine
from tests.kits.program import HEAD, load, picture

BACKENDS = NAMES


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_all_sixteen_logic_functions(backend: str, name: str, tmp_path: Path) -> None:
    program = load(tmp_path, HEAD + f'[[step]]\nlogic = "{name}"\nof = ["p", "q"]\nto = "r"\n')
    p, q = np.array([[0, 0, 1, 1]], bool), np.array([[0, 1, 0, 1]], bool)
    meaning: dict[str, Any] = {
        "white": lambda p, q: False, "nor": lambda p, q: not (p or q), "not-p-and-q": lambda p, q: not p and q,
        "not-p": lambda p, q: not p, "p-and-not-q": lambda p, q: p and not q, "not-q": lambda p, q: not q,
        "xor": lambda p, q: p != q, "nand": lambda p, q: not (p and q), "and": lambda p, q: p and q,
        "equal": lambda p, q: p == q, "q": lambda p, q: q, "not-p-or-q": lambda p, q: not p or q, "p": lambda p, q: p,
        "p-or-not-q": lambda p, q: p or not q, "or": lambda p, q: p or q, "black": lambda p, q: True,
    }  # fmt: skip
    result = UniversalMachine(backend).run(program, p=p, q=q)["r"]
    assert result.tolist() == [[bool(meaning[name](a, b)) for a, b in zip(p[0], q[0], strict=True)]]


@pytest.mark.parametrize("backend", BACKENDS)
def test_template_cellwise_copy_fill_and_wires(backend: str, tmp_path: Path) -> None:
    text = """
name = "all-kinds"
lam = ["a", "b", "c", "half"]
llm = ["p", "edge"]
wire = ["any", "all", "count"]
inputs = ["a", "p"]
outputs = ["edge", "c", "any", "all", "count"]
[parameters]
gain = 2.0
[[step]]
template = "edge"
input = "p"
to = "edge"
[[step]]
copy = "edge"
to = "b"
[[step]]
cellwise = "multiply"
of = ["a", "b"]
to = "c"
[[step]]
fill = 0.5
to = "half"
[[step]]
cellwise = "subtract"
of = ["c", "half"]
to = "c"
[[step]]
cellwise = "scale"
of = "c"
to = "c"
parameters = ["gain", 1]
[[step]]
wire = "any"
of = "edge"
to = "any"
[[step]]
wire = "all"
of = "edge"
to = "all"
[[step]]
wire = "count"
of = "edge"
to = "count"
"""
    program = load(tmp_path, text, parameters={"gain": 3.0})
    p = picture()
    a = np.random.default_rng(1).uniform(-1, 1, p.shape)
    out = UniversalMachine(backend).run(program, a=a, p=p)
    inner = ndimage.binary_erosion(p, np.ones((3, 3)))
    edge = p & ~inner
    assert np.array_equal(out["edge"], edge)
    assert out["c"] == pytest.approx(3 * (np.where(edge, a, -a) - 0.5) + 1, abs=1e-6)
    assert (out["any"], out["all"], out["count"]) == (1, 0, edge.sum())


@pytest.mark.parametrize("backend", BACKENDS)
def test_repeat_until_unchanged_and_branches(backend: str, tmp_path: Path) -> None:
    """Erode twice; then grow inside the mask until nothing changes: reconstruction. Then choose by the wire."""
    text = """
name = "reconstruction"
llm = ["mask", "seed", "result"]
wire = ["found"]
inputs = ["mask"]
outputs = ["result", "found"]
[[step]]
copy = "mask"
to = "seed"
[[step]]
repeat = 2
[[step.do]]
template = "erosion-square"
boundary = { fixed = -1 }
input = "seed"
to = "seed"
[[step]]
until_unchanged = "seed"
[[step.do]]
template = "dilation-square"
input = "seed"
to = "seed"
[[step.do]]
logic = "and"
of = ["seed", "mask"]
to = "seed"
[[step]]
wire = "any"
of = "seed"
to = "found"
[[step]]
when = "found"
[[step.do]]
copy = "seed"
to = "result"
[[step.otherwise]]
logic = "not-p"
of = ["mask"]
to = "result"
"""
    program = load(tmp_path, text)
    machine = UniversalMachine(backend)
    mask = ndimage.binary_dilation(np.random.default_rng(3).random((30, 40)) < 0.02, iterations=3)
    square = np.ones((3, 3))
    seed = ndimage.binary_erosion(mask, square, iterations=2)
    assert seed.any()
    assert np.array_equal(machine.run(program, mask=mask)["result"], ndimage.binary_propagation(seed, square, mask))
    thin = np.zeros((5, 6), bool)
    thin[2] = True
    out = machine.run(program, mask=thin)
    assert np.array_equal(out["result"], ~thin)
    assert out["found"] == 0


@pytest.mark.parametrize("backend", BACKENDS)
def test_kept_planes_live_from_run_to_run(backend: str, tmp_path: Path) -> None:
    text = (
        HEAD.replace('["p", "q"]\noutputs', '["p"]\noutputs')
        + """
[keep]
q = -1
[[step]]
logic = "or"
of = ["p", "q"]
to = "q"
[[step]]
copy = "q"
to = "r"
"""
    )
    program, machine = load(tmp_path, text), UniversalMachine(backend)
    pictures = [picture(seed) for seed in range(3)]
    for i, frame in enumerate(pictures):
        assert np.array_equal(machine.run(program, p=frame)["r"], np.logical_or.reduce(pictures[: i + 1]))
    machine.reset()
    assert np.array_equal(machine.run(program, p=pictures[2])["r"], pictures[2])


def test_a_program_s_own_template_can_be_replaced(tmp_path: Path) -> None:
    text = (
        HEAD + '[templates.rule]\nA = [[0]]\nB = [[1]]\n[[step]]\ntemplate = "rule"\ninput = "p"\nstate = 0\nto = "r"\n'
    )
    p = picture()
    plain = UniversalMachine("reference").run(load(tmp_path, text), p=p, q=p)["r"]
    inverted = load(tmp_path, text, templates={"rule": Template([[0]], [[-1]])})
    assert np.array_equal(plain, p)
    assert np.array_equal(UniversalMachine("reference").run(inverted, p=p, q=p)["r"], ~p)
    with pytest.raises(InputError, match="no template 'ruel' to replace; the program defines rule"):
        load(tmp_path, text, templates={"ruel": Template([[0]])})


def test_function_numbers_are_truth_tables() -> None:
    assert function_number("and") == 0b1000
    assert function_number("or") == 0b1110
    assert function_number("p") == 0b1100
