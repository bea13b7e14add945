"""Names of files' own making stay inside the folder that was given."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim.cli.group import main
from cnnsim.support import InputError
from cnnsim.support.files import check_name
from cnnsim.support.pictures.picture import write_picture
from tactile.core.frame import TaxelArray
from tests.cnnsim.support.test_terminal import TEMPLATE

BAD = ["", "../x", "a/b", "a b", "a\x1b", "..", "-o", "a.b", "C:x", "größe", "a\n", "=1+1", "x" * 101]
PROGRAM = """
name = {name}
inputs = ["picture"]
outputs = [{plane}]
llm = ["picture", {plane}]
[[step]]
copy = "picture"
to = {plane}
"""


@pytest.mark.parametrize("name", ["a", "A-1_b", "_x", "0", "x" * 100])
def test_names_of_letters_digits_and_lines_are_taken(name: str) -> None:
    assert check_name(name, "finger") == name


@pytest.mark.parametrize("name", BAD)
def test_other_names_are_refused_wherever_a_file_gives_them(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"letters, digits, - and _ wanted"):
        TaxelArray(name, 1, 1, 1e-3, 1e-3)
    write_picture(np.ones((2, 2)), tmp_path / "in.png")
    text = '"' + "".join(f"\\u{ord(c):04x}" for c in name) + '"'
    (tmp_path / "out").mkdir()
    for names in ({"name": '"p"', "plane": text}, {"name": text, "plane": '"y"'}):
        (tmp_path / "p.toml").write_text(PROGRAM.format(**names), encoding="utf-8")
        command = ["program", str(tmp_path / "p.toml"), "--input", f"picture={tmp_path / 'in.png'}"]
        result = CliRunner().invoke(main, [*command, "-o", str(tmp_path / "out")])
        assert result.exit_code == 2
        assert "letters, digits, - and _ wanted" in result.stderr
        assert len(result.stderr.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.png", "out", "p.toml"]
    assert not list((tmp_path / "out").iterdir())


def test_another_name_of_a_template_leads_to_no_file_outside(tmp_path: Path) -> None:
    text = TEMPLATE.format(text='"x"').replace('tags = ["odd"]', 'aliases = ["../../../escaped"]')
    (tmp_path / "odd.toml").write_text(text, encoding="utf-8")
    command = ["--library", str(tmp_path), "export", "../../../escaped", "--format", "gene"]
    result = CliRunner().invoke(main, [*command, "-o", str(tmp_path / "a" / "b")])
    assert result.exit_code == 2
    assert not list(tmp_path.rglob("*.gene"))
