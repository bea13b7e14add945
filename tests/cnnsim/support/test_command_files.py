"""Outputs of all commands: never an input, never two in one file, never over an existing file without --replace."""

import os
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result

from cnnsim import InputError, write_picture
from cnnsim.cli.group import main as cnnsim
from cnnsim.support.command_files import claim, command_files, note_read
from cnnsim.support.files import write_text, writing
from tactile.cli.group import main as tactile
from tests.kits.paths import SCENES

GROUPS = {"cnnsim": cnnsim, "tactile": tactile}


def call(line: str) -> Result:
    program, *arguments = line.split()
    return CliRunner().invoke(GROUPS[program], arguments)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    for name in ("in.png", "mask.png", "out/opened.png", "out/edge-0.png"):
        write_picture(np.where(np.eye(9) > 0, 1.0, -1.0), name)
    scene = (SCENES / "needle.toml").read_text(encoding="utf-8")
    Path("s.toml").write_text(scene, encoding="utf-8")
    call("tactile convert s.toml out/frames.csv")
    Path("w.csv").write_text("from_s,to_s,grams\n0,1,1\n")
    Path("link.png").symlink_to("in.png")
    Path("same").symlink_to("out")
    os.link("mask.png", "hard.png")
    return tmp_path


INPUT = """\
cnnsim run edge in.png -o in.png
cnnsim run edge link.png -o in.png
cnnsim run edge in.png -o link.png
cnnsim run edge in.png --mask mask.png -o hard.png
cnnsim run edge out -o same
cnnsim program opening --input picture=out/opened.png -o out
cnnsim robust edge --picture in.png -o in.png
cnnsim accuracy edge in.png --csv in.png
tactile run out/frames.csv -o same
tactile convert out/frames.csv same/frames.csv
tactile calibrate out/frames.csv --weights w.csv -o w.csv
tactile explain s.toml --write s.toml
tactile accuracy s.toml --csv s.toml""".splitlines()
TWICE = """\
cnnsim run edge in.png -o two.gif --trajectory ./two.gif
cnnsim trace edge in.png -o x --film x
cnnsim accuracy edge -o x.svg --csv x.svg
tactile accuracy s.toml -o x.svg --csv out/../x.svg""".splitlines()


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("line", INPUT + TWICE)
def test_an_output_is_no_input_and_no_other_output(line: str) -> None:
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    for more in ("", " --replace"):
        refused = call(line + more)
        assert refused.exit_code == 2, refused.output
        assert refused.stderr.count("\n") == 1
    assert ("two outputs" if line in TWICE else "is the") in refused.stderr or "a plot is one of" in refused.stderr
    assert before == {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}


@pytest.mark.parametrize("group", GROUPS)
def test_every_command_with_an_output_has_replace(group: str) -> None:
    commands: list[Any] = list(GROUPS[group].commands.values())
    while commands:
        command = commands.pop()
        commands += getattr(command, "commands", {}).values()
        names = {name for option in command.params if isinstance(option, click.Option) for name in option.opts}
        assert not names & {"-o", "--csv", "--film", "--trajectory", "--write", "--record"} or "--replace" in names, (
            command.name
        )


def test_a_command_reads_what_it_wrote_and_devices_take_several_outputs(tmp_path: Path) -> None:
    path, replaced = tmp_path / "x", list[Path]()
    with command_files(replaced.append):
        claim(path)
        with writing(path) as temporary:
            temporary.write_text("1")
            with pytest.raises(InputError, match="is the input"):
                note_read(path)
        note_read(path)
        for text in "56":
            write_text("/dev/null", text)
        with pytest.raises(InputError, match="two outputs are one file"):
            write_text(path, "2")
    note_read(path)
    write_text(path, "7")  # in Python nothing is recorded
    assert (path.read_text(), replaced) == ("7", [])
