"""Programs: every kind of step runs on every backend, and a wrong file is refused before anything runs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from cnnsim import InputError, Template
from cnnsim.backends import NAMES
from cnnsim.logic import FUNCTIONS, function_number
from cnnsim.machine import UniversalMachine
from cnnsim.program_file import load_program

BACKENDS = NAMES
HEAD = 'name = "p"\nlam = ["a", "b"]\nllm = ["p", "q", "r"]\nwire = ["n"]\ninputs = ["p", "q"]\noutputs = ["r"]\n'


def _load(tmp_path: Path, text: str, **changes: Any) -> Any:
    file = tmp_path / "p.toml"
    file.write_text(text, encoding="utf-8")
    return load_program(file, **changes)


def _picture(seed: int = 0, shape: tuple[int, int] = (12, 15)) -> np.ndarray:
    return np.random.default_rng(seed).random(shape) < 0.5


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_all_sixteen_logic_functions(backend: str, name: str, tmp_path: Path) -> None:
    program = _load(tmp_path, HEAD + f'[[step]]\nlogic = "{name}"\nof = ["p", "q"]\nto = "r"\n')
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
name = "all kinds"
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
    program = _load(tmp_path, text, parameters={"gain": 3.0})
    p = _picture()
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
    program = _load(tmp_path, text)
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
    program, machine = _load(tmp_path, text), UniversalMachine(backend)
    pictures = [_picture(seed) for seed in range(3)]
    for i, picture in enumerate(pictures):
        assert np.array_equal(machine.run(program, p=picture)["r"], np.logical_or.reduce(pictures[: i + 1]))
    machine.reset()
    assert np.array_equal(machine.run(program, p=pictures[2])["r"], pictures[2])


def test_a_program_s_own_template_can_be_replaced(tmp_path: Path) -> None:
    text = (
        HEAD + '[templates.rule]\nA = [[0]]\nB = [[1]]\n[[step]]\ntemplate = "rule"\ninput = "p"\nstate = 0\nto = "r"\n'
    )
    p = _picture()
    plain = UniversalMachine("reference").run(_load(tmp_path, text), p=p, q=p)["r"]
    inverted = _load(tmp_path, text, templates={"rule": Template([[0]], [[-1]])})
    assert np.array_equal(plain, p)
    assert np.array_equal(UniversalMachine("reference").run(inverted, p=p, q=p)["r"], ~p)
    with pytest.raises(InputError, match="no template 'ruel' to replace; the program defines rule"):
        _load(tmp_path, text, templates={"ruel": Template([[0]])})


STEP = "[[step]]\n"


@pytest.mark.parametrize(("body", "message"), [
    ('logic = "xro"\nof = ["p", "q"]\nto = "r"', r"step 1 \(logic xro\): logic function 'xro'; known are"),
    ('logic = "xor"\nof = ["p", "s"]\nto = "r"', r"step 1 .*'s' is not declared; declared are a, b, p"),
    ('logic = "xor"\nof = ["p", "a"]\nto = "r"', r"step 1 .*'a' is in lam; llm wanted"),
    ('logic = "xor"\nof = ["p", "r"]\nto = "r"', r"step 1 .*'r' is read before anything has been written"),
    ('logic = "xor"\nof = ["p", "q"]', r"step 1 .*no 'to'"),
    ('logic = "xor"\nof = ["p", "q"]\nto = "r"\nmask = "p"', r"step 1 .*unknown key 'mask'"),
    ('template = "edg"\ninput = "p"\nto = "r"', r"step 1 .*did you mean edge"),
    ('template = "edge"\nto = "r"', r"step 1 .*'input' must name a plane"),
    ('template = "recall"\ninput = "p"\nto = "r"', r"step 1 .*'state' must name the plane"),
    ('template = "edge"\ninput = "p"\nto = "r"\nboundary = "torus"', r"step 1 .*boundary 'torus'"),
    ('cellwise = "add"\nof = ["a"]\nto = "b"', r"step 1 .*1 inputs; 2 wanted: p, q"),
    ('cellwise = "frobnicate"\nof = ["a"]\nto = "b"', r"step 1 .*no cellwise operation is called 'frobnicate'"),
    ('fill = "gain"\nto = "r"', r"step 1 .*no parameter 'gain'"),
    ('wire = "some"\nof = "p"\nto = "n"', r"step 1 .*global wire 'some'; known are any, all, count"),
    ('wire = "any"\nof = "p"\nto = "q"', r"step 1 .*'q' is in llm; wire wanted"),
    ('repeat = 0\n[[step.do]]\ncopy = "p"\nto = "r"', r"step 1 .*times 0; a whole number from 1"),
    ("repeat = 2\ndo = []", r"step 1\.: no steps"),
    (
        'repeat = 2\n[[step.do]]\ncopy = "p"\nto = "r"\n[[step.do]]\ncopy = "x"\nto = "r"',
        r"step 1\.2 \(copy x\): 'x' is not",
    ),
    ('copy = "p"\nlogic = "and"\nof = ["p"]\nto = "r"', r"step 1: has logic and copy of"),
    ('to = "r"', "step 1: has none of template"),
])  # fmt: skip
def test_a_wrong_step_is_named(body: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        _load(tmp_path, HEAD + STEP + body + "\n")


def test_what_only_one_branch_writes_cannot_be_read(tmp_path: Path) -> None:
    body = 'wire = "any"\nof = "p"\nto = "n"\n[[step]]\nwhen = "n"\n[[step.do]]\ncopy = "p"\nto = "r"\n'
    with pytest.raises(InputError, match="outputs: 'r' is read before"):
        _load(tmp_path, HEAD + STEP + body)
    _load(tmp_path, HEAD + STEP + body + '[[step.otherwise]]\ncopy = "q"\nto = "r"\n')


@pytest.mark.parametrize(("text", "message"), [
    ("name = 1 =", "is no TOML"),
    (HEAD, "no 'step'"),
    (HEAD + 'colour = "red"\n[[step]]\ncopy = "p"\nto = "r"\n', "unknown key 'colour'"),
    (HEAD.replace('"b"]', '"p"]') + '[[step]]\ncopy = "p"\nto = "r"\n', "'p' is declared as lam and as llm"),
    (HEAD + '[templates.t]\nA = [[1, 2]]\n[[step]]\ncopy = "p"\nto = "r"\n', r"templates\.t: .*1 x 2, an odd square"),
])  # fmt: skip
def test_a_wrong_file_is_refused(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        _load(tmp_path, text)


def test_missing_files_wrong_inputs_and_endless_loops(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no program file"):
        load_program(tmp_path / "none.toml")
    program = _load(tmp_path, HEAD + '[[step]]\nlogic = "xor"\nof = ["p", "q"]\nto = "r"\n')
    machine = UniversalMachine("reference")
    with pytest.raises(InputError, match="got p; p, q wanted"):
        machine.run(program, p=_picture())
    with pytest.raises(InputError, match="one shape"):
        machine.run(program, p=_picture(), q=_picture(0, (3, 3)))
    step = '[[step]]\nuntil_unchanged = "p"\nlimit = 5\n[[step.do]]\nlogic = "not-p"\nof = ["p"]\nto = "p"\n'
    blinking = HEAD + step + '[[step]]\ncopy = "p"\nto = "r"\n'
    with pytest.raises(InputError, match=r"step 1 .*still changing after 5 rounds"):
        machine.run(_load(tmp_path, blinking), p=_picture(), q=_picture())


def test_function_numbers_are_truth_tables() -> None:
    assert function_number("and") == 0b1000
    assert function_number("or") == 0b1110
    assert function_number("p") == 0b1100
