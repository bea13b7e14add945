"""What users get wrong ends in one line and exit code 2, whatever the library below would have raised."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cnnsim import write_picture
from cnnsim.cli.group import main
from cnnsim.support.pictures.film import BETWEEN, STRIP
from cnnsim.support.toml_file import check_keys
from tests.kits.paths import ROOT


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, n in (("one.png", 16), ("small.png", 9)):
        write_picture(np.where(np.random.default_rng(n).random((n, n)) > 0.5, 1.0, -1.0), tmp_path / name)
    (tmp_path / "file").write_text("")
    return tmp_path


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("run hole-filler one.png --time 1e18", "1e+18 time constants in steps of 0.1; at most 1e+12 steps wanted"),
        ("run hole-filler one.png --step 1e-300", "in steps of 1e-300; at most 1e+12 steps wanted"),
        ("run hole-filler one.png --time 1e308 --step 1e-3", "at most 1e+12 steps wanted"),
        ("run recall one.png --state small.png", "second picture has shape (9, 9), the first (16, 16)"),
        (["run", "edge", ""], "argument 2 of run is empty; a value wanted"),
        (["program", "skeleton", "--input", "picture=one.png", "-o", ""], "argument 5 of program is empty"),
        ("run 123 one.png", "no template '123' in the library; `cnnsim list` shows all"),
        ("explain edge --size -3x4", "size '-3x4'; ROWSxCOLS wanted"),
        ("program skeleton --input picture=one.png -o file", "the folder file: file is no folder"),
    ],
)
def test_one_line(folder: Path, command: str | list[str], message: str) -> None:
    done = CliRunner().invoke(main, command.split() if isinstance(command, str) else command)
    assert done.exit_code == 2
    assert message in done.output
    assert len(done.output.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('step = "x"', "step = 'x', a finite number wanted"),
        ("margin = true", "margin = True, a finite number wanted"),
        ("tags = 3", "tags = 3, a list wanted"),
        ("aliases = [1]", "aliases = [1], a list of texts wanted"),
        ("example = 1", "'example' is 1, [[example]] tables wanted"),
        ("note = 2", "note = 2, a text wanted"),
    ],
)
def test_keys_of_another_kind_in_a_template_file(folder: Path, line: str, message: str) -> None:
    keep = ("summary", "reference", "A ", "B ", "z ", "input", "initial_state", "boundary", "duration")
    source = (ROOT / "templates" / "dilation-cross.toml").read_text()
    lines = [text for text in source.split("[[example]]")[0].splitlines() if text.startswith(keep)]
    (folder / "lib").mkdir()
    (folder / "lib" / "mine.toml").write_text("\n".join(['name = "mine"', line, *lines]))
    done = CliRunner().invoke(main, ["--library", "lib", "run", "mine", "one.png"])
    assert done.exit_code == 2, done.output
    assert message in done.output


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("inputs = 3", "inputs = 3, a list wanted"),
        ("outputs = 3", "outputs = 3, a list wanted"),
        ('keep = "x"', "keep = 'x', a table wanted"),
        ("keep = { opened = true }", "keep: opened: True is no finite number"),
        ("templates = 3", "templates = 3, a table wanted"),
        ("parameters = 3", "parameters = 3, a table wanted"),
        ("summary = 3", "summary = 3, a text wanted"),
    ],
)
def test_keys_of_another_kind_in_a_program_file(folder: Path, line: str, message: str) -> None:
    source = (ROOT / "templates" / "programs" / "opening.toml").read_text()
    lines = [text for text in source.splitlines() if not text.startswith(line.split()[0])]
    (folder / "mine.toml").write_text("\n".join([line, *lines]))
    done = CliRunner().invoke(main, ["program", "mine.toml", "--input", "picture=one.png"])
    assert done.exit_code == 2, done.output
    assert message in done.output


def test_a_film_of_two_layers_shows_them_side_by_side(folder: Path) -> None:
    done = CliRunner().invoke(main, ["run", "autowave", "one.png", "--trajectory", "film.gif"])
    assert done.exit_code == 0, done.output
    with Image.open(folder / "film.gif") as film:
        side = film.height - 2 * STRIP  # below the cells the layer, below that the time
        assert film.width == 2 * side + BETWEEN


def test_all_that_is_wrong_with_a_table_is_told_at_once() -> None:
    with pytest.raises(ValueError, match=r"x: unknown key 'nmae'; did you mean 'name'\?; no 'name', 'size'"):
        check_keys({"nmae": 1}, ("name", "size"), "x", ("name", "size"))


def test_an_alias_is_a_name() -> None:
    for name in ("FIGDEL", "figdel"):
        done = CliRunner().invoke(main, ["show", name])
        assert done.exit_code == 0, done.output
