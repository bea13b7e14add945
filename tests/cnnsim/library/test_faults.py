"""All errors of a file are reported at once, each with its line."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cnnsim import InputError
from cnnsim.library.read import load_file
from cnnsim.program.file import load_program
from cnnsim.prototyping.design.rule_files import read_table
from cnnsim.support.error_list import ErrorList
from cnnsim.support.toml_file import MOST_FAULTS
from cnnsim.sweep.spec import read_sweep

TEMPLATE = """\
name = "shadow-box"
sumary = "misspelt"
reference = ["a list"]
A = [[0, 0], [0, 1]]
B = "q"
input = "pictur"
boundary = "torus"
duration = -3
tags = [3]
accuracy = "best"
cell = "foo"
[[example]]
input = ["..", "#"]
[[term]]
weights = [[1, 2]]
of = "foo"
"""
LAYERS = """\
name = "two"
summary = "s"
reference = "r"
input = "none"
initial_state = "any"
boundary = "zero-flux"
duration = 1
[[layer]]
A = [[1, 2]]
[[layer]]
A = 1
z = "x"
[[layer.term]]
weights = 1
delay = -1
"""
PROGRAM = """\
name = "b"
inputs = ["a", "c"]
llm = ["a", "b"]
keep = 3
[[step]]
logic = "nand2"
of = ["a", "zz"]
to = "b"
[[step]]
copy = "b"
to = "a"
[[step]]
copi = "a"
to = "b"
[[step]]
repeat = 2
do = [ { copy = "a", to = "u" }, { logic = "xro" } ]
"""
RULE = """\
black = [ ["...", "..."], ["###", "###", "###"] ]
white = [ ["###", "###", "##?"] ]
defalt = "x"
default = "grey"
"""
SWEEP = """\
kind = "transients"
foo = 3
[grid]
templat = ["edge"]
cells = 3
[fixed]
cells = 3
"""


@pytest.mark.parametrize(("name", "text", "read", "told"), [
    ("shadow-box", TEMPLATE, load_file,
     {"sumary": 2, "no 'summary', 'initial_state', 'z'": None, "reference =": 3, "input is 'pictur'": 6,
      "boundary 'torus'": 7, "duration = -3": 8, "tags =": 9, "accuracy 'best'": 10, "cell model 'foo'": 11,
      "no 'output'": 12, "row 2 of a picture": 13, "weights is 1 x 2": 15, "argument 'foo'": 16, "A is 2 x 2": 4,
      "B is no rectangular": 5}),
    ("two", LAYERS, load_file,
     {"layer 0: no 'z'": 8, "A is 1 x 2": 9, "z is 'x'": 12, "layer 1: term 0: term: delay": 15}),
    ("b", PROGRAM, load_program,
     {"no 'outputs'": None, "'c' is not declared": 2, "keep = 3": 4, "'nand2'": 5, "'zz' is not declared": 5,
      "step 3: has none": 12, "step 4.1 (copy a): 'u'": 17, "step 4.2 (logic xro): no 'of', 'to'": 17,
      "step 4.2 (logic xro): logic function 'xro'": 17}),
    ("rule", RULE, read_table,
     {"defalt": 3, "three strings of three": 1, "in both lists, black and white": 2, "default is 'grey'": 4}),
    ("s", SWEEP, lambda path: read_sweep(path, {"transients": "cnnsim.sweep.transients"}),
     {"'foo'": 2, "'templat'": 4, "no 'template'": 3, "cells in [grid] and in [fixed]": 6, "cells = 3": 5}),
])  # fmt: skip
def test_all_errors_of_a_file_are_reported_at_once(
    name: str, text: str, read: Callable[[Path], Any], told: dict[str, int | None], tmp_path: Path
) -> None:
    file = tmp_path / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read(file)
    message = str(error.value)
    for fault, line in told.items():
        assert fault in message
        where = rf"{re.escape(fault)}[^;]*(;[^;]*)?(; did you mean [^;]*)?\(line {line}\)"
        assert line is None or re.search(where, message), (fault, line, message)
    assert "read before" not in message  # what a wrong step would have written is no fault of the next one


def test_of_many_errors_the_first_are_reported() -> None:
    faults = ErrorList("x.toml")
    for number in range(MOST_FAULTS + 5):
        faults.check({f"key-{number}": 1}, ("a",))
        faults.check({f"key-{number}": 1}, ("a",))  # the same once more is no other fault
    assert len(faults) == MOST_FAULTS + 5
    with pytest.raises(InputError, match=r"'key-19'; known are a; and 5 more$"):
        faults.raise_all()
