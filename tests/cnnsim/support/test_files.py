"""Files are written whole or not at all, and what is replaced is told, by every command that writes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cnnsim import InputError, write_picture
from cnnsim.cli.group import main
from cnnsim.support.command_files import check_free
from cnnsim.support.files import write_text, writing


def call(*arguments: Any) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    picture = np.where(np.random.default_rng(0).random((9, 9)) < 0.5, 1.0, -1.0)
    write_picture(picture, "in.png")
    return tmp_path


def test_a_file_is_there_whole_or_not_at_all(folder: Path) -> None:
    (folder / "x.txt").write_text("before")
    with pytest.raises(KeyboardInterrupt), writing("x.txt") as temporary:
        temporary.write_text("half")
        assert temporary.name == "x.txt"  # the ending decides the format
        assert (folder / "x.txt").read_text() == "before"
        raise KeyboardInterrupt
    assert (folder / "x.txt").read_text() == "before"
    assert sorted(path.name for path in folder.iterdir()) == ["in.png", "x.txt"]


def test_what_is_wrong_is_said_of_the_name_that_was_given(folder: Path) -> None:
    with pytest.raises(InputError, match=r"^cannot write the recording x\.mcap: full$"), writing("x.mcap") as temporary:
        raise InputError(f"cannot write the recording {temporary}: full")


def test_links_rights_and_devices_stay_what_they_are(folder: Path) -> None:
    (folder / "x.txt").write_text("before")
    (folder / "x.txt").chmod(0o640)
    (folder / "link.txt").symlink_to("x.txt")
    write_text("link.txt", "after")
    assert (folder / "link.txt").is_symlink()
    assert (folder / "x.txt").read_text() == "after"
    assert (folder / "x.txt").stat().st_mode & 0o777 == 0o640
    write_text("/dev/null", "nothing")
    assert Path("/dev/null").is_char_device()


def test_a_file_that_is_not_to_be_replaced(folder: Path) -> None:
    write_text("x.txt", "before", replace=False)
    with pytest.raises(InputError, match=r"x.txt is there already; --replace"):
        write_text("x.txt", "after", replace=False)
    with pytest.raises(InputError, match=r"x.txt, x.txt are there already; --replace would write over them"):
        check_free(Path("x.txt"), Path("x.txt"), replace=False)
    assert (folder / "x.txt").read_text() == "before"


def test_what_cannot_be_written_is_named(folder: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write none/x.png: No such file"):
        write_picture(np.ones((2, 2)), "none/x.png")
    with pytest.raises(InputError, match=r"cannot write x.none: unknown file extension"):
        write_picture(np.ones((2, 2)), "x.none")
    with pytest.raises(InputError, match=r"cannot make the folder in.png"):
        write_text("in.png/x.txt", "")


@pytest.mark.usefixtures("folder")
def test_python_is_told_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    write_picture(np.ones((2, 2)), "in.png")
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("command", "files"),
    [
        ("run edge in.png -o out.png --trajectory film.gif", ["out.png", "film.gif"]),
        ("trace edge in.png -o out.svg --film film.gif", ["out.svg", "film.gif"]),
        ("robust edge --draws 1 -o out.svg", ["out.svg"]),
        ("program opening --input picture=in.png -o out", ["out/opened.png"]),
        ("program opening --input picture=in.png -o out.gif", ["out.gif"]),
    ],
)
def test_every_command_says_what_it_replaces(folder: Path, command: str, files: list[str]) -> None:
    first, refused, second = (call(*command.split(), *more) for more in ([], [], ["--replace"]))
    assert refused.exit_code == 2
    assert f"{files[-1]} " in refused.stderr
    assert "there already; --replace would write over" in refused.stderr
    assert first.exit_code == second.exit_code == 0, second.output
    assert "replaced" not in first.stderr
    assert second.stderr.splitlines() == [f"replaced {file}" for file in files]
    assert first.stdout == second.stdout


@pytest.mark.parametrize(
    ("command", "files"),
    [
        ("design --rule c --name thin -o mine", ["mine/thin.toml"]),
        (
            "design --rule c.xor.x --name thin -o mine",
            ["mine/thin-1.toml", "mine/thin-2.toml", "mine/programs/thin.toml"],
        ),
        ("design --pair in.png=in.png --coupled --state 1 --generations 5 --name thin -o mine", ["mine/thin.toml"]),
        ("export edge --format tem -o mine", ["mine/edge.tem"]),
    ],
)
def test_what_is_replaced_only_when_told(folder: Path, command: str, files: list[str]) -> None:
    words = [word.replace(".", " ") if "xor" in word else word for word in command.split()]
    done = call(*words)
    assert done.exit_code == 0, done.output
    mine = folder / files[-1]
    mine.write_text("my own work")
    refused = call(*words)
    assert refused.exit_code == 2
    assert f"{files[-1]} " in refused.stderr
    assert "there already; --replace would write over" in refused.stderr
    assert mine.read_text() == "my own work"
    replaced = call(*words, "--replace")
    assert replaced.exit_code == 0, replaced.output
    assert replaced.stderr.splitlines() == [f"replaced {file}" for file in files]
    assert mine.read_text() != "my own work"


def test_json_stays_json(folder: Path) -> None:
    for _ in range(2):
        done = call("run", "edge", "in.png", "-o", "out.png", "--json", "--replace")
    assert done.stderr == "replaced out.png\n"
    assert json.loads(done.stdout)["template"] == "edge"
