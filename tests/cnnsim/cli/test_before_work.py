"""What cannot end well is refused before any work; choices that would be passed over are refused; so is JSON told."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import write_picture
from cnnsim.cli.group import main

REFUSED = [
    ("run edge one.png -o none/x.png", "cannot write none/x.png: there is no folder none"),
    ("run edge one.png -o x.foo", "cannot write x.foo: unknown file extension: .foo"),
    ("run edge one.png -o one.png/x/", "one.png is no folder"),
    ("run edge one.png -o x.png --trajectory x.foo", "cannot write x.foo: a film is one of .gif"),
    ("run edge one.png -o x.png --trajectory none/x.gif", "there is no folder none"),
    ("run edge one.png --store s --workers 1 -o x.foo", "cannot write x.foo: unknown file extension"),
    ("trace edge one.png -o x.png --film x.foo", "cannot write x.foo: a film is one of .gif"),
    ("trace edge one.png -o x.foo --film x.gif", "cannot write x.foo: a plot is one of"),
    ("accuracy diffusion -o x.foo", "cannot write x.foo: a plot is one of"),
    ("accuracy diffusion --csv none/x.csv", "there is no folder none"),
    ("robust edge -o x.foo", "cannot write x.foo: a plot is one of"),
    ("program opening --input picture=one.png -o one.png/x", "one.png is no folder"),
    ("run edge one.png --block 8", "--block 8 without an engine; --engine processes, or dask=ADDRESS, wanted"),
    ("run edge one.png --workers 1", "--workers 1 without an engine"),
    ("program opening --input picture=one.png --workers 1", "--workers 1 without an engine"),
    ("program opening --input picture=", "--input 'picture='; NAME=VALUE wanted"),
    ("program opening --input =one.png", "--input '=one.png'; NAME=VALUE wanted"),
    ("program opening --input picture=one.png --still x=", "--still 'x='; NAME=VALUE wanted"),
    ("program gray-opening --input picture=one.png --set radius=2 --set radius=3", "radius=3: radius is 2 already"),
    ("design --pair =one.png --name x -o d", "pair '=one.png'; INPUT=OUTPUT wanted"),
    ("run edge -", "argument 2 of run is '-'; a file wanted, no standard input or output"),
    ("run edge one.png -o -", "argument 4 of run is '-'; a file wanted"),
]  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_picture(np.where(np.random.default_rng(4).random((9, 7)) > 0.5, 1.0, -1.0), tmp_path / "one.png")
    return tmp_path


def computed(*_arguments: Any, **_options: Any) -> None:
    raise AssertionError("work was done")


@pytest.mark.parametrize(("command", "message"), REFUSED)
def test_before_anything_is_computed_or_written(
    folder: Path, command: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("task.Task.start", "program.machine.UniversalMachine.run", "prototyping.robust.robust.measure",
                 "prototyping.accuracy.work_precision.reference_state",
                 "supersteps.transient.run_on_engine"):  # fmt: skip
        monkeypatch.setattr(f"cnnsim.{name}", computed)
    done = CliRunner().invoke(main, command.split())
    assert done.exit_code == 2, done.output
    assert message in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert [path.name for path in folder.iterdir()] == ["one.png"]


@pytest.mark.parametrize(("command", "message"), [
    ("run edge none.png --json", "no picture none.png"),
    ("run autowave one.png --json --time -1", "duration -1.0"),
    ("show edg --json", "did you mean"),
    ("list --tag none --json", "no template has the tag"),
    ("run edge one.png --jsn --json", "No such option '--jsn'"),
    ("robust edge --draws 0 --json", "0 is not in the range"),
    ("nothing --json", "No such command 'nothing'"),
])  # fmt: skip
def test_what_is_refused_is_json_too(folder: Path, command: str, message: str) -> None:
    done = CliRunner().invoke(main, command.split())
    assert done.exit_code == 2
    assert message in json.loads(done.stdout)["error"]
    assert message in done.stderr


def test_a_folder_for_the_result_of_an_engine(folder: Path) -> None:
    done = CliRunner().invoke(main, ["run", "edge", "one.png", "--store", "s", "--workers", "1", "-o", "made"])
    assert done.exit_code == 0, done.output
    assert (folder / "made" / "edge.png").is_file()
