"""A wrong program file is refused before anything runs, and the step is named."""

from pathlib import Path

import pytest

from cnnsim import InputError
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from tests.kits.program import HEAD, load, picture

STEP = "[[step]]\n"


@pytest.mark.parametrize(("body", "message"), [
    ('logic = "xro"\nof = ["p", "q"]\nto = "r"', r"step 1 \(logic xro\): logic function 'xro'; known are"),
    ('logic = "xor"\nof = ["p", "s"]\nto = "r"', r"step 1 .*'s' is not declared; declared are a, b, p"),
    ('logic = "xor"\nof = ["p", "a"]\nto = "r"', r"step 1 .*'a' is in lam; llm wanted"),
    ('logic = "xor"\nof = ["p", "r"]\nto = "r"', r"step 1 .*'r' is read before anything has been written"),
    ('logic = "xor"\nof = ["p", "q"]', r"step 1 .*no 'to'"),
    ('logic = "xor"\nof = ["p", "q"]\nto = "r"\nmask = "p"', r"step 1 .*unknown key 'mask'"),
    ('template = "edg"\ninput = "p"\nto = "r"', r"step 1 .*did you mean edge"),
    ('template = "edge"\nto = "r"', r"step 1 .*no 'input', but the template has a B"),
    ('template = "recall"\ninput = "p"\nto = "r"', r"step 1 .*: no 'state'; the name of a plane or a number"),
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
    ('template = 3\nto = "r"', r"step 1 \(template 3\): a name wanted"),
    ('cellwise = []\nof = ["a"]\nto = "b"', r"step 1 \(cellwise \[\]\): a name wanted"),
    ('template = "edge"\ninput = [1]\nto = "r"', r"step 1 .*: \[1\] is no finite number"),
    ('template = "recall"\ninput = "p"\nstate = nan\nto = "r"', r"step 1 .*: nan is no finite number"),
    (f"fill = 1{'0' * 400}\nto = \"r\"", r"step 1 \(fill 10* \.\.\.\): 10* \.\.\. is no finite number"),
])  # fmt: skip
def test_a_wrong_step_is_named(body: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        load(tmp_path, HEAD + STEP + body + "\n")


def test_what_only_one_branch_writes_cannot_be_read(tmp_path: Path) -> None:
    body = 'wire = "any"\nof = "p"\nto = "n"\n[[step]]\nwhen = "n"\n[[step.do]]\ncopy = "p"\nto = "r"\n'
    with pytest.raises(InputError, match="outputs: 'r' is read before"):
        load(tmp_path, HEAD + STEP + body)
    load(tmp_path, HEAD + STEP + body + '[[step.otherwise]]\ncopy = "q"\nto = "r"\n')


@pytest.mark.parametrize(("text", "message"), [
    ("name = 1 =", "not TOML"),
    (HEAD, "no 'step'"),
    (HEAD + 'colour = "red"\n[[step]]\ncopy = "p"\nto = "r"\n', "unknown key 'colour'"),
    (HEAD.replace('"b"]', '"p"]') + '[[step]]\ncopy = "p"\nto = "r"\n', "'p' is declared as lam and as llm"),
    (HEAD.replace('"b"]', "3]") + '[[step]]\ncopy = "p"\nto = "r"\n', r"lam is \['a', 3\]; a list of names wanted"),
    (HEAD + 'templates = {t = 5}\n[[step]]\ncopy = "p"\nto = "r"\n', r"templates\.t: 5, a table wanted"),
    (HEAD + '[templates.t]\nA = [[1, 2]]\n[[step]]\ncopy = "p"\nto = "r"\n', r"templates\.t: .*1 x 2, an odd square"),
])  # fmt: skip
def test_a_wrong_file_is_refused(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        load(tmp_path, text)


def test_missing_files_wrong_inputs_and_endless_loops(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no program file"):
        load_program(tmp_path / "none.toml")
    program = load(tmp_path, HEAD + '[[step]]\nlogic = "xor"\nof = ["p", "q"]\nto = "r"\n')
    machine = UniversalMachine("reference")
    with pytest.raises(InputError, match="got p; p, q wanted"):
        machine.run(program, p=picture())
    with pytest.raises(InputError, match="one shape"):
        machine.run(program, p=picture(), q=picture(0, (3, 3)))
    step = '[[step]]\nuntil_unchanged = "p"\nlimit = 5\n[[step.do]]\nlogic = "not-p"\nof = ["p"]\nto = "p"\n'
    blinking = HEAD + step + '[[step]]\ncopy = "p"\nto = "r"\n'
    with pytest.raises(InputError, match=r"step 1 .*still changing after 5 rounds"):
        machine.run(load(tmp_path, blinking), p=picture(), q=picture())
