"""The command `cnnsim design`: files it writes and mistakes it names."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import library, write_picture
from cnnsim.cli.design import design as design_command
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.support import InputError
from tests.oracles.pictures import plane
from tests.oracles.wholes import fill_holes


def run(*arguments: str) -> Any:
    return CliRunner().invoke(design_command, list(arguments))


def test_the_command_writes_a_template_that_the_library_reads(tmp_path: Path) -> None:
    result = run("--rule", "c and ring8 < 8", "--name", "my-edge", "-o", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "checked   all 512 windows" in result.output
    entry = library.load_file(tmp_path / "my-edge.toml")
    assert len(entry.examples) == 2
    assert all(example.holds(library.run_example(entry, example).y) for example in entry.examples)


def test_the_command_writes_a_program(tmp_path: Path) -> None:
    result = run("--rule", "c xor x", "--name", "differs", "-o", str(tmp_path), "--json")
    data = json.loads(result.output)
    assert not data["single"]
    assert data["certificate"]["black"][0]["share"] == "1/2"
    program = load_program(tmp_path / "programs" / "differs.toml")
    picture, state = plane(np.array([[0, 0, 1, 1]]) > 0), plane(np.array([[0, 1, 0, 1]]) > 0)
    out = UniversalMachine().run(program, picture=picture, state=state)["result"]
    assert (out > 0).tolist() == [[False, True, True, False]]


def test_the_command_on_pairs_of_pictures(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    drawn = rng.random((8, 9)) < 0.5
    write_picture(plane(drawn), tmp_path / "in.png")
    write_picture(library.run("corner", plane(drawn)).y, tmp_path / "out.png")
    write_picture(plane(fill_holes(drawn)), tmp_path / "filled.png")
    pair = f"{tmp_path / 'in.png'}={tmp_path / 'out.png'}"
    assert "are open" in run("--pair", pair, "--name", "learned", "-o", str(tmp_path)).output
    entry = library.load_file(tmp_path / "learned.toml")
    shown = entry.examples[0].input
    assert shown is not None
    assert np.array_equal(shown, plane(drawn))
    pair = f"{tmp_path / 'in.png'}={tmp_path / 'filled.png'}"
    result = run("--pair", pair, "--coupled", "--state", "1", "--name", "filled", "-o", str(tmp_path))
    assert result.exit_code == 0, result.exception
    assert library.load_file(tmp_path / "filled.toml").initial_state == 1


def test_the_best_template_of_a_search_that_fails_is_kept(tmp_path: Path) -> None:
    drawn = np.random.default_rng(0).random((2, 8, 9)) < 0.5
    for name, picture in zip(("in", "out"), drawn, strict=True):
        write_picture(plane(picture), tmp_path / f"{name}.png")
    pair = f"{tmp_path / 'in.png'}={tmp_path / 'out.png'}"
    call = ["--pair", pair, "--coupled", "--generations", "1", "--name", "learned", "-o", str(tmp_path)]
    error = run(*call).exception
    assert isinstance(error, InputError)
    assert f"is kept as {tmp_path / 'learned-attempt.toml'}; try more" in str(error)
    kept = library.load_file(tmp_path / "learned-attempt.toml")
    wrong = int((kept.summary.split(";")[1]).split()[0])
    y = library.run(kept, plane(drawn[0]), limit=60.0).y
    assert (y * plane(drawn[1]) <= 0).sum() == wrong > 0
    assert "is there already" in str(run(*call).exception)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--name", "x"],
        ["--rule", "c", "--table", "t.toml", "--name", "x"],
        ["--rule", "c", "--name", "Bad Name"],
        ["--rule", "c", "--name", "x", "--coupled"],
        ["--pair", "one.png", "--name", "x"],
        ["--pair", "a=b", "--name", "x"],
    ],
)
def test_mistakes(arguments: list[str], tmp_path: Path) -> None:
    assert isinstance(run(*arguments, "-o", str(tmp_path)).exception, InputError)
