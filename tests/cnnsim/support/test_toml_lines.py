"""What is wrong with a file is told with its line, of whatever key or step it is."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from cnnsim import InputError, library, load_program
from cnnsim.prototyping.design.rule_files import read_table
from cnnsim.support.toml_lines import LinedTable, with_lines
from tests.kits.paths import ROOT

TEMPLATE = """name = "mine"
summary = "s"
reference = "r"
A = [[0, 0, 0],
     [0, 1, 0], # a comment = 3
     [0, 0, 0]]
B = 1
z = 0
input = "picture"
initial_state = "any"
boundary = "zero-flux"
duration = "settled"

[[example]]
input = ["#."]
output = ["#."]
"""
PROGRAM = """name = "mine"
lam = ["grey"]
llm = ["picture", "out"]
wire = ["some"]
inputs = ["picture"]
outputs = ["out"]
keep = { out = -1 }

step = [
  { copy = "picture", to = "out" },
  { repeat = 2, do = [
    { template = "erosion-square", input = "out", to = "out" },
    { logic = "not-p", of = ["out"], to = "out" },
  ] },
]

[templates]
own = { A = [[1]], B = 1 }
"""


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("[0, 1, 0],", "[0, 1],", 4),
        ("B = 1", "B = [[1, 2]]", 7),
        ("z = 0", 'z = "x"', 8),
        ("z = 0", "zz = 0", 8),
        ('"picture"\ninitial', '"image"\ninitial', 9),
        ('"any"', '"some"', 10),
        ('"zero-flux"', '"torus"', 11),
        ('"settled"', '"x"', 12),
        ('"settled"', "-1", 12),
        ("[[example]]", "margin = true\n[[example]]", 14),
        ("[[example]]", 'cell = "y"\n[[example]]', 14),
        ("[[example]]", 'tags = "y"\n[[example]]', 14),
        ('output = ["#."]', 'output = ["#"]', 14),
        ('output = ["#."]', 'output = ["#x"]', 16),
        ('output = ["#."]', "", 14),
        ('output = ["#."]', 'output = ["#."]\ntolerance = "x"', 17),
        ('summary = "s"\n', "", 13),
        ('summary = "s"', "summary = 3", 2),
        ('summary = "s"', "summary = s", 2),
        ('summary = "s"', 'summary = "\udcff"', 2),
        ('name = "mine"', 'name = "yours"', 1),
    ],
)
def test_of_a_template(tmp_path: Path, old: str, new: str, line: int) -> None:
    file = tmp_path / "mine.toml"
    assert TEMPLATE.count(old) == 1
    file.write_bytes(TEMPLATE.encode())
    library.load_file(file)
    file.write_bytes(TEMPLATE.replace(old, new).encode(errors="surrogateescape"))
    with pytest.raises(InputError, match=rf"mine\.toml: .*line {line}\b") as error:
        library.load_file(file)
    lines = 2 if new == "zz = 0" else 1  # that of the misspelt key, and where the missing one belongs
    assert len(re.findall(r"line \d", str(error.value))) == lines


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('lam = ["grey"]', "lam = 3", 2),
        ('lam = ["grey"]', 'lam = ["grey"]\nlamb = 3', 3),
        ('wire = ["some"]', 'wire = ["out"]', 4),
        ('inputs = ["picture"]', 'inputs = ["some"]', 5),
        ('inputs = ["picture"]', "inputs = 3", 5),
        ('inputs = ["picture"]\n', "", 16),
        ('outputs = ["out"]', 'outputs = ["nothing"]', 6),
        ("out = -1", 'out = "x"', 7),
        ('copy = "picture"', 'copy = "none"', 10),
        ('to = "out" },\n  { repeat', 'ot = "out" },\n  { repeat', 10),
        ("repeat = 2", "repeat = -2", 11),
        ('"erosion-square"', '"erosion-squar"', 12),
        ('"erosion-square", input', '"erosion-square", duration = "x", input', 12),
        ('"not-p"', '"not"', 13),
        ('of = ["out"]', 'off = ["out"]', 13),
        ("A = [[1]]", "A = [[1, 2]]", 18),
        ("B = 1", "B = 1, duration = []", 18),
    ],
)
def test_of_a_program(tmp_path: Path, old: str, new: str, line: int) -> None:
    file = tmp_path / "mine.toml"
    assert PROGRAM.count(old) == 1, old
    file.write_text(PROGRAM)
    load_program(file)
    file.write_text(PROGRAM.replace(old, new))
    with pytest.raises(InputError, match=rf"mine\.toml: .*line {line}\b"):
        load_program(file)


def test_all_missing_keys_at_once_and_where_they_belong(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('name = "mine"\n\n[[term]]\n')
    wanted = (
        "no 'summary', 'reference', 'input', 'initial_state', 'boundary', 'duration', 'A', 'z' (wanted before the first"
    )
    with pytest.raises(InputError, match=re.escape(f"{wanted} table, line 3)")):
        library.load_file(file)
    file.write_text("")
    with pytest.raises(InputError, match=r"no 'name', .*\(line 1 is free\)"):
        library.load_file(file)


def test_of_a_truth_table(tmp_path: Path) -> None:
    file = tmp_path / "rule.toml"
    file.write_text('default = "white"\nblack = [["###", "###", "##"]]\n')
    with pytest.raises(InputError, match=r"rule\.toml: window .* \(line 2\)"):
        read_table(file)


def test_every_key_of_every_file_is_found() -> None:
    def check(value: Any, lines: list[str]) -> int:
        if isinstance(value, LinedTable):
            assert set(value.lines) == set(value)
            assert all(key in lines[line - 1] for key, line in value.lines.items())
            return len(value) + sum(check(item, lines) for item in value.values())
        return sum(check(item, lines) for item in value) if isinstance(value, list) else 0

    files = [*(ROOT / "templates").rglob("*.toml"), *(ROOT / "examples").rglob("*.toml"), ROOT / "pyproject.toml"]
    found = 0
    for file in files:
        text = file.read_text()
        data = with_lines(tomllib.loads(text), text)
        assert data == tomllib.loads(text)
        found += check(data, text.split("\n"))
    assert found > 3000


@pytest.mark.parametrize(
    "text",
    [
        "a = 1\r\nb = 2\r\n[c]\r\nd = 3",
        'x = \'\'\'\n[a]\nb = 1\'\'\'\nb = """\n# no \\""" comment"""\nd = 1',
        "a.b.c = 1 # [d]\n'd e' = { f = [ { g = 1 },\n { h = '}' } ], i.j = 2 }\n\"k.l\" = 1979-05-27 07:32:00",
        "[[a]]\n[[a.b]]\nc = 1\n[[a.b]]\nc = 2\n[[a]]\n[a.d]\ne = 1.5e3\n[a.d.f]\n",
        "a = [1, # one\n 2,\n]\n\n\n[ b . c ]\nd=[[],[[1]]]\n",
    ],
)
def test_all_of_toml(text: str) -> None:
    data = with_lines(tomllib.loads(text), text)
    assert data == tomllib.loads(text)

    def check(value: Any) -> None:
        if isinstance(value, LinedTable):
            for key, line in value.lines.items():
                assert key in text.split("\n")[line - 1]
            assert set(value.lines) == set(value)
        for item in value.values() if isinstance(value, dict) else value if isinstance(value, list) else []:
            check(item)

    check(data)
