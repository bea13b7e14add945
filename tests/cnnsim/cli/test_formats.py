"""Import and export as commands."""

import json
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result

from cnnsim import InputError, library
from cnnsim.cli.formats import export, import_
from cnnsim.formats.candy.parse import read_tem
from cnnsim.formats.candy.terms import section_template
from cnnsim.formats.differences import number_differences
from cnnsim.formats.files import import_file
from cnnsim.library.imported import Imported
from cnnsim.network import Template
from cnnsim.support import Diagnostics
from cnnsim.support.command_line import CommandGroup
from tests.kits.formats import HOLE

SIX = "neighborhood: 2\ncontrol:\n0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 0\n"

TWICE = "neighborhood: 0\ncontrol:\n1\ncontrol:\n2\ncurrent: 0\n"

KINDS: dict[str, tuple[str, list[object]]] = {
    "nonlinear": ("nonlin_control:\na-\na 0 1 0 .3\ncurrent: 0\n", [0.3, 0.3]),
    "delayed": ("control:\n1\ndelay: 2\ndelayed_control:\n1\ncurrent: 0\n", [0.5, 1.0]),
    "layers": ("nrlayers 2\nlayer 1\ncontrol from 1\n1\nlayer 2\nfeedback from 1\n-1\n", [[0.25, 0.5], [-0.25, -0.5]]),
    "discrete": ("%CNNModel: DT-CNN\ncontrol:\n1\ncurrent: 0\n", [1.0, 1.0]),
}


@click.group(cls=CommandGroup)
def main() -> None:
    """The two commands by themselves."""


main.add_command(import_)

main.add_command(export)


def call(*words: str | Path) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def plain(text: str) -> str:
    return " ".join(text.split())


def test_import_writes_files_that_load_and_run(tmp_path: Path) -> None:
    (tmp_path / "HOLE.tem").write_text(HOLE)
    result = call("import", tmp_path / "HOLE.tem", "-o", tmp_path / "mine")
    assert result.exit_code == 0, result.output
    entry = library.load_file(tmp_path / "mine" / "hole.toml")
    assert not list(number_differences(entry.network, library.load("hole-filler").network))
    assert (entry.summary, entry.initial_state, str(entry.boundary)) == ("Fills holes.", 1, "fixed 0")
    assert entry.aliases == ("HOLE", "HoleFiller")
    assert entry.examples == ()
    assert not entry.shipped
    assert "white front cannot enter" in entry.note  # what the library knows of it goes along
    assert "white front cannot enter" in result.output
    with library.using(tmp_path / "mine"):
        assert library.run("hole", np.ones((3, 3)), boundary=entry.boundary).y.min() == 1


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_imported_and_runs(tmp_path: Path, kind: str) -> None:
    text, wanted = KINDS[kind]
    (tmp_path / f"{kind}.tem").write_text("%Setting: Input:P, IniState:0, Boundary:Fixed(0)\nneighborhood: 0\n" + text)
    result = import_file(tmp_path / f"{kind}.tem", tmp_path)
    assert [path.stem for path in result.written] == [kind], result.report.lines()
    entry = library.load_file(tmp_path / f"{kind}.toml")
    y = library.run(entry, np.array([[0.25, 0.5]]), backend="reference").y
    assert np.allclose(np.squeeze(y), np.array(wanted), atol=1e-3)
    read = section_template(read_tem(text.encode(), Diagnostics("x")).sections[0], "x")
    assert list(number_differences(read, entry.network)) == []


def test_a_bad_file_does_not_stop_the_others(tmp_path: Path) -> None:
    files = {"bad.tem": SIX, "good.tem": HOLE, "odd.tem": TWICE}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    result = call("import", *(tmp_path / name for name in files), tmp_path / "none.tem", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["good.toml"]
    assert f"{tmp_path / 'bad.tem'}:5: error: CONTROL: a row of 6 in a matrix of 5 columns" in result.output
    assert f"{tmp_path / 'none.tem'}: error: No such file" in result.output
    assert "odd: parsed, not written: CONTROL twice in layer 1" in result.output
    assert "4 files: 1 template written, 1 parsed but not written, 2 files failed" in result.output


def test_import_writes_over_nothing_unless_told(tmp_path: Path) -> None:
    (tmp_path / "HOLE.tem").write_text(HOLE)
    words = ("import", tmp_path / "HOLE.tem", "-o", tmp_path)
    assert call(*words).exit_code == 0
    again = call(*words)
    assert again.exit_code == 2
    assert "is there already" in again.output
    assert call(*words, "--replace").exit_code == 0


def test_import_as_json(tmp_path: Path) -> None:
    (tmp_path / "bad.tem").write_text(SIX)
    result = call("import", tmp_path / "bad.tem", "-o", tmp_path, "--json")
    (facts,) = json.loads(result.output)
    assert facts["failed"]
    assert {"severity": "error", "line": 5} in [{k: d[k] for k in ("severity", "line")} for d in facts["diagnostics"]]


def test_formats_go_by_suffix_or_by_option(tmp_path: Path) -> None:
    (tmp_path / "g.txt").write_text("0 " * 14 + "2" + " 0" * 4)
    unknown = call("import", tmp_path / "g.txt", "-o", tmp_path)
    assert unknown.exit_code == 2
    assert "'.txt' is not known" in unknown.output
    assert call("import", tmp_path / "g.txt", "--format", "gene", "-o", tmp_path).exit_code == 0
    assert library.load_file(tmp_path / "g.toml").template.state_bound() == 2


def test_an_import_that_would_hide_a_shipped_template_says_so(tmp_path: Path) -> None:
    (tmp_path / "Edge.tem").write_text(HOLE)
    assert "hides the shipped template" in call("import", tmp_path / "Edge.tem", "-o", tmp_path).output


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("DEADENDH", ("3", "1"), "z between -4 and -3.5"),
        ("HOLE", ("Fixed(0)", "Fixed(-1)"), ""),
        ("HOLE", ("-1", "-2"), "differs from the library's hole-filler: z is -2, not -1"),
        ("WAVE", ("0", "0"), "coupled, with a boundary of 0"),
        ("FLAT", ("feedback:\n0 1 0\n1 3 1\n0 1 0\n", "feedback:\n2\n"), ""),
        ("FLAT", ("feedback:\n0 1 0\n1 3 1\n0 1 0\ncontrol:\n0 0 0\n0 4 0\n0 0 0\ncurrent: -1",
                  "feedback:\n2\ncontrol:\n4\ncurrent: -5.5"), "the output is white for every input"),
        ("CNTR3", ("0", "0"), "peels past the centre"),
        ("FIGREC", ("feedback:\n0 1 0\n1 3 1\n0 1 0", "feedback:\n.5 .5 .5\n.5 4 .5\n.5 .5 .5"), "z is -1, not 3"),
    ],
)  # fmt: skip
def test_known_defects_are_warnings(tmp_path: Path, name: str, change: tuple[str, str], words: str) -> None:
    (tmp_path / f"{name}.tem").write_text(HOLE.replace(*change))
    warnings = [item.message for item in import_file(tmp_path / f"{name}.tem", tmp_path).report.of("warning")]
    mine = [message for message in warnings if "NEIGHBORHOOD" not in message]
    assert any(words in message for message in mine) if words else mine == []


def test_names_and_texts_survive_toml() -> None:
    text = 'quotes " and \\ and \x7f and tab\t and \ud800 and ü'
    imported = Imported("x", text, "r", Template([[1]]), input="none", note="n", aliases=("a",))
    import tomllib

    data = tomllib.loads(imported.text())
    assert data["summary"] == text.replace("\ud800", "?")
    with pytest.raises(InputError, match="not yet"):
        Imported("x", "s", "r", Template([[1]]), missing="not yet").text()


def test_export_and_import_again(tmp_path: Path) -> None:
    result = call("export", "edge", "hole-filler", "--format", "tem", "-o", tmp_path)
    assert result.exit_code == 0, result.output
    assert call("import", tmp_path / "hole-filler.tem", "-o", tmp_path).exit_code == 0
    entry = library.load_file(tmp_path / "hole-filler.toml")
    assert (entry.boundary, entry.initial_state) == (library.load("hole-filler").boundary, 1)
    assert call("export", "edge", "--format", "tem", "-o", tmp_path).exit_code == 2  # it is there already
    assert call("export", "edge", "--format", "tem", "-o", tmp_path, "--replace").exit_code == 0


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [("autowave", "json", "not linear"), ("edgy", "json", "did you mean")],
)
def test_export_writes_what_can_be_written_and_names_the_rest(tmp_path: Path, name: str, kind: str, words: str) -> None:
    for order in (("edge", name), (name, "edge")):
        result = call("export", *order, "--format", kind, "-o", tmp_path / order[0])
        assert result.exit_code == (2 if words else 0)
        assert words in plain(result.stderr)
        assert ("1 of 2 templates written" in result.stderr) == bool(words)
        written = {path.name for path in (tmp_path / order[0]).iterdir()}
        assert written == {f"edge.{kind}"} | (set() if words else {f"{name}.{kind}"})


def test_an_export_of_nothing_makes_no_folder(tmp_path: Path) -> None:
    assert call("export", "autowave", "--format", "json", "-o", tmp_path / "out").exit_code == 2
    assert not (tmp_path / "out").exists()


def test_an_import_that_fails_leaves_what_it_was_to_replace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "HOLE.tem").write_text(HOLE)
    words = ("import", tmp_path / "HOLE.tem", "-o", tmp_path, "--replace")
    assert call(*words).exit_code == 0
    before = (tmp_path / "hole.toml").read_text()
    monkeypatch.setattr(Imported, "text", lambda _: 'name = "hole"')
    again = call(*words)
    assert again.exit_code == 2
    assert f"{tmp_path / 'hole.toml'}: no 'summary'" in again.output
    assert (tmp_path / "hole.toml").read_text() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["HOLE.tem", "hole.toml"]
