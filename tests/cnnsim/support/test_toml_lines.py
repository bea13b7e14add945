"""Line numbers of the keys and tables of TOML files, and errors that have them."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from cnnsim import InputError, library
from cnnsim.prototyping.design.rule_files import read_table
from cnnsim.support.toml_lines import LinedTable, with_lines
from tests.kits.paths import ROOT


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
