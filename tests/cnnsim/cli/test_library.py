"""The library at the door: files that are wrong stop nothing, new ones run as they are, programs are shown too."""

import json
import os
import socket
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from scipy import ndimage

from cnnsim import library, load_program, read_picture, write_picture
from cnnsim.cli.group import main
from cnnsim.library import folders


def call(*arguments: Any) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library with one right template and files of seven kinds that are none."""
    place = tmp_path / "lib"
    assert call("new", "template", "mine", "-o", place).exit_code == 0
    (place / "empty.toml").touch()
    (place / "folder.toml").mkdir()
    os.mkfifo(place / "pipe.toml")
    (place / "typo.toml").write_text(
        (place / "mine.toml").read_text().replace('"mine"', '"typo"').replace("z =", "zz =")
    )
    (place / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (place / "gone.toml").symlink_to(place / "nowhere.toml")
    with socket.socket(socket.AF_UNIX) as end:
        monkeypatch.chdir(place)  # the name of a socket is short
        end.bind("socket.toml")
    return place


BAD = {"empty", "folder", "pipe", "typo", "binary", "gone", "socket"}


def test_broken_files_are_listed_with_their_errors(broken: Path) -> None:
    listed = call("--library", broken, "list", "--json")
    assert listed.exit_code == 0
    found = {entry["name"]: entry for entry in json.loads(listed.output)}
    assert {name for name, entry in found.items() if "error" in entry} == BAD
    assert len(found) == len(library.names()) + 1 + len(BAD)
    assert "unknown key 'zz' (line " in found["typo"]["error"]
    assert "a folder; a template file wanted" in found["folder"]["error"]
    assert "no plain file" in found["pipe"]["error"]
    text = " ".join(call("--library", broken, "list").output.split())
    assert "mine Black pixels" in text
    for name in BAD:
        assert f"{name} BROKEN: " in text


def test_the_others_are_found_by_name_alias_and_tag(broken: Path) -> None:
    assert call("--library", broken, "show", "FIGDEL").exit_code == 0
    assert "mine" in call("--library", broken, "list", "--tag", "binary").output
    for name in BAD:
        shown = call("--library", broken, "show", name)
        assert shown.exit_code == 2
        assert len(shown.output.strip().splitlines()) == 1


def test_broken_programs_are_listed_too(tmp_path: Path) -> None:
    assert call("new", "program", "mine", "-o", tmp_path).exit_code == 0
    (tmp_path / "programs" / "bad.toml").write_text('name = "bad"')
    (tmp_path / "programs" / "dir.toml").mkdir()
    found = {
        entry["name"]: entry for entry in json.loads(call("--library", tmp_path, "list", "--programs", "--json").output)
    }
    assert {name for name, entry in found.items() if "error" in entry} == {"bad", "dir"}
    assert "no 'inputs', 'outputs', 'step'" in found["bad"]["error"]
    assert "mine" in found


def test_a_new_template_runs_as_it_is(tmp_path: Path) -> None:
    picture = ndimage.binary_dilation(np.random.default_rng(0).random((30, 40)) < 0.02, iterations=2)
    write_picture(picture, tmp_path / "in.png")
    made = call("new", "template", "mine", "-o", tmp_path / "lib")
    assert f"-> {tmp_path / 'lib' / 'mine.toml'}" in made.output.replace("\n  ", " ")
    for way in (("--library", tmp_path / "lib", "run", "mine"), ("run", tmp_path / "lib" / "mine.toml")):
        assert call(*way, tmp_path / "in.png", "-o", tmp_path / "out.png", "--replace").exit_code == 0
        edge = picture & ~ndimage.binary_erosion(picture, np.ones((3, 3)))
        assert np.array_equal(read_picture(tmp_path / "out.png") > 0, edge)
    entry = library.load_file(tmp_path / "lib" / "mine.toml")
    assert entry.examples[0].holds(library.run_example(entry, entry.examples[0]).y)


def test_a_new_program_runs_as_it_is(tmp_path: Path) -> None:
    picture = ndimage.binary_dilation(np.random.default_rng(0).random((30, 40)) < 0.02, iterations=3)
    write_picture(picture, tmp_path / "in.png")
    assert call("new", "program", "mine", "-o", tmp_path).exit_code == 0
    for rounds in (1, 2):
        how = (
            "--input",
            f"picture={tmp_path / 'in.png'}",
            "--set",
            f"rounds={rounds}",
            "--replace",
            "-o",
            tmp_path / "out",
            "--json",
        )
        ran = call("--library", tmp_path, "program", "mine", *how)
        rim = picture & ~ndimage.binary_erosion(picture, np.ones((3, 3)), iterations=rounds, border_value=1)
        assert np.array_equal(read_picture(tmp_path / "out" / "rim.png") > 0, rim)
        assert json.loads(ran.stdout)["outputs"]["pixels"] == rim.sum()


@pytest.mark.parametrize("kind", ["template", "program"])
def test_what_is_there_is_not_replaced_unless_asked(tmp_path: Path, kind: str) -> None:
    path = tmp_path / ("programs" if kind == "program" else "") / "mine.toml"
    path.parent.mkdir(exist_ok=True)
    path.write_text("precious")
    refused = call("new", kind, "mine", "-o", tmp_path)
    assert refused.exit_code == 2
    assert "--replace" in refused.output
    assert path.read_text() == "precious"
    assert call("new", kind, "mine", "-o", tmp_path, "--replace").exit_code == 0
    assert path.read_text() != "precious"
    assert call("new", kind, "My Edge", "-o", tmp_path).exit_code == 2


def test_programs_are_shown_and_explained() -> None:
    text = call("show", "slip-front").output
    assert "Taxels whose shear turned" in text
    assert "level = 0.25" in text
    assert "29  copy of contact -> touched" in text
    facts = json.loads(call("show", "slip-front", "--json").output)
    assert facts["outputs"] == ["slipped", "slid", "stuck", "front", "slipping"]
    assert len(facts["steps"]) == 29
    steps = json.loads(call("explain", "slip-front", "--size", "16x16", "--json").output)["steps"]
    assert [step["method"] for step in steps] == [*["closed form"] * 4, "packed logic"]
    assert "step 26: template dilation-square" in call("explain", "slip-front").output
    assert "packed logic" in call("explain", "opening").output


@pytest.mark.parametrize("name", list(folders.programs()))
def test_every_program_is_shown_and_explained(name: str) -> None:
    given = name if name not in library.names() else f"programs/{name}"
    assert call("show", given).output.split()[0] == f"{name}:"
    assert call("explain", given, "--size", "16x16").exit_code == 0
    assert str(load_program(name)).count(name)


def test_a_name_of_both_is_the_template_and_a_name_of_the_other_kind_is_told() -> None:
    assert "Somewhere between" in call("show", "median").output
    assert "removes single wrong" in " ".join(call("show", "programs/median").output.split())
    for words, message in (
        (("run", "slip-front", __file__), "a program of that name: `cnnsim program slip-front`"),
        (("program", "edge"), "a template of that name: `cnnsim run edge`"),
        (("show", "slip-frnt"), "no template 'slip-frnt'"),
        (("explain", "slip-front", "--without", "sleep"), "--without goes with templates"),
    ):
        result = call(*words)
        assert result.exit_code == 2
        assert message in result.output


@pytest.mark.parametrize("columns", ["80", "60"])
def test_what_is_printed_fits_the_terminal(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, columns: str) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    write_picture(np.eye(20), tmp_path / "a.png")
    for words in (
        ("list",), ("list", "--programs"), ("show", "median"), ("show", "corner"), ("show", "slip-front"),
        ("explain", "hole-filler"), ("explain", "slip-front"), ("robust", "corner", "--draws", "1"),
        ("run", "edge", tmp_path / "a.png"), ("program", "opening", "--input", f"picture={tmp_path / 'a.png'}"),
        ("design", "--rule", "all9 % 2 == 1", "--name", "parity", "-o", tmp_path),
    ):  # fmt: skip
        result = call(*words)
        assert result.exit_code == 0, result.output
        for line in result.output.splitlines():
            assert len(line) <= int(columns) or max(map(len, line.split())) > 40, line  # a path
