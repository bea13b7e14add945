"""The machine's command line as a user meets it: right runs, and one clear line with exit code 2 for mistakes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from scipy import ndimage

from cnnsim import library, read_picture, write_picture
from cnnsim.cli.group import main


def _call(*arguments: Any) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def blobs(tmp_path: Path) -> Path:
    values = ndimage.binary_dilation(np.random.default_rng(0).random((40, 50)) < 0.02, iterations=2)
    write_picture(values, tmp_path / "blobs.png")
    return tmp_path / "blobs.png"


def test_help_shows_examples() -> None:
    for command in ("list", "show", "run", "explain", "program"):
        result = _call(command, "--help")
        assert result.exit_code == 0
        assert f"cnnsim {command}" in result.output.split("Examples:")[1]


def test_list_and_tags() -> None:
    listed = [line for line in _call("list").output.splitlines() if line[0] != " "]
    assert len(listed) == len(library.names()) >= 40
    names = [item["name"] for item in json.loads(_call("list", "--tag", "morphology", "--json").output)]
    assert "erosion-square" in names
    assert "edge" not in names


def test_show_draws_the_example() -> None:
    text = _call("show", "shift-e").output
    assert "source" in text
    assert "Example" in text
    assert json.loads(_call("show", "edge", "--json").output)["B"][1] == [-1, 8, -1]


@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_run_writes_the_picture(blobs: Path, tmp_path: Path, backend: str) -> None:
    out = tmp_path / "edge.png"
    result = _call("run", "edge", blobs, "-o", out, "--backend", backend, "--json")
    black = read_picture(blobs) > 0
    edge = black & ~ndimage.binary_erosion(black, np.ones((3, 3)))
    assert np.array_equal(read_picture(out) > 0, edge)
    assert json.loads(result.output)["black"] == edge.sum()


def test_run_with_every_option_of_the_transient(blobs: Path, tmp_path: Path) -> None:
    film = tmp_path / "wave.gif"
    how = ("--time", 2, "--scheme", "rk4", "--step", 0.05, "--boundary", "periodic", "--cell", "full-range")
    where = ("-o", tmp_path / "soft.png", "--dtype", "float64", "--trajectory", film)
    result = _call("run", "diffusion", blobs, *how, *where)
    assert result.exit_code == 0, result.output
    before, after = read_picture(blobs), read_picture(tmp_path / "soft.png")
    assert after.mean() == pytest.approx(before.mean(), abs=5e-3)
    assert after.std() < before.std()
    with Image.open(film) as gif:
        assert gif.n_frames > 10  # type: ignore[attr-defined]  # GIFs have frames


def test_grey_pictures_of_other_formats_and_two_pictures(blobs: Path, tmp_path: Path) -> None:
    grey = np.linspace(-1, 1, 64).reshape(8, 8)
    write_picture(grey, tmp_path / "grey.tiff")
    assert _call("run", "threshold-zero", tmp_path / "grey.tiff", "-o", tmp_path / "t.bmp").exit_code == 0
    assert np.array_equal(read_picture(tmp_path / "t.bmp") > 0, read_picture(tmp_path / "grey.tiff") > 0)
    black = read_picture(blobs) > 0
    label, count = ndimage.label(black, np.ones((3, 3)))
    assert count > 1
    seed = np.zeros_like(black)
    seed[tuple(np.argwhere(label == 1)[0])] = True
    write_picture(seed, tmp_path / "seed.png")
    assert _call("run", "recall", blobs, "--state", tmp_path / "seed.png", "-o", tmp_path / "one.png").exit_code == 0
    assert np.array_equal(read_picture(tmp_path / "one.png") > 0, label == 1)


def test_program_opening_is_scipy_s(blobs: Path, tmp_path: Path) -> None:
    result = _call("program", "opening", "--input", f"picture={blobs}", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    opened = ndimage.binary_opening(read_picture(blobs) > 0, np.ones((3, 3)))
    assert np.array_equal(read_picture(tmp_path / "out" / "opened.png") > 0, opened)


def test_a_program_s_parameter_can_be_set(blobs: Path, tmp_path: Path) -> None:
    for radius in (1, 2):
        how = ("--input", f"picture={blobs}", "--set", f"radius={radius}", "-o", tmp_path, "--replace")
        assert _call("program", "gray-opening", *how).exit_code == 0
        wanted = ndimage.grey_opening(read_picture(blobs), size=2 * radius + 1, mode="nearest")
        found = read_picture(next(tmp_path.glob("opened.png")))
        assert np.array_equal(found[4:-4, 4:-4] > 0, wanted[4:-4, 4:-4] > 0)


def test_explain_says_what_was_decided() -> None:
    assert "closed form" in _call("explain", "edge").output
    text = _call("explain", "hole-filler", "--size", "100x20").output
    assert "5 of the 9 entries" in text
    assert "euler, h = 0.1" in text
    assert json.loads(_call("explain", "laplace-solver", "--json").output)["step"] == pytest.approx(0.1)
    off = _call("explain", "hole-filler", "--without", "sleep").output.splitlines()
    assert "no sleep           switched off: tiles in which" in "\n".join(off)
    assert any(line.startswith("guaranteed time    4915 time constants") for line in off)  # one column
    assert "half the stability limit" in _call("explain", "surface-interpolation").output


@pytest.mark.parametrize(("arguments", "message"), [
    (("run", "egde", "BLOBS"), "did you mean edge"),
    (("run", "edge", "none.png"), "no picture none.png"),
    (("run", "edge", __file__), "is no picture"),
    (("run", "edge", "BLOBS", "--boundary", "torus"), "boundary 'torus'"),
    (("run", "edge", "BLOBS", "--time", "-1"), "duration -1.0"),
    (("run", "laplace-solver", "BLOBS", "--step", "0.3", "--time", "1"), "step 0.3 cannot be stable"),
    (("run", "recall", "BLOBS"), "takes a second picture"),
    (("run", "edge", "BLOBS", "--scheme", "leapfrog"), "leapfrog"),
    (("explain", "edge", "--size", "big"), "ROWSxCOLS"),
    (("list", "--tag", "nonsense"), "tags are"),
    (("program", "none.toml"), "no program file"),
    (("program", "skelton"), "did you mean skeleton"),
    (("show", "slip-frnt"), "did you mean the program slip-front"),
    (("list", "--programs", "--tag", "morphology"), "programs have no tags"),
    (("trace", "edge", "BLOBS", "BLOBS", "--json"), "takes one picture, 2 were given"),
    (("program", "gray-opening", "--set", "radius=two"), "a number wanted"),
    (("program", "gray-opening", "--set", "raduis=2"), "raduis"),
    (("run", "edge", "BLOBS", "--device", "0"), "only the opencl backend"),
    (("--library", "nowhere", "list"), "library nowhere"),
    (("program", "opening"), "picture wanted"),
    (("run", "hole-filler", "BLOBS", "--time", "1e18"), "1e+18 time constants in steps of 0.1; at most 1e+12 steps"),
    (("run", "hole-filler", "BLOBS", "--step", "1e-300"), "in steps of 1e-300; at most 1e+12 steps wanted"),
    (("run", "recall", "BLOBS", "--state", "SMALL"), "second picture has shape (9, 9), the first (40, 50)"),
    (("run", "edge", ""), "argument 2 of run is empty; a value wanted"),
    (("program", "skeleton", "--input", "picture=BLOBS", "-o", ""), "argument 5 of program is empty"),
    (("run", "123", "BLOBS"), "no template '123' in the library; `cnnsim list` shows all"),
])  # fmt: skip
def test_a_mistake_is_one_line_and_exit_code_two(arguments: tuple[str, ...], message: str, blobs: Path) -> None:
    write_picture(np.ones((9, 9)), small := blobs.with_name("small.png"))
    result = _call(*(word.replace("BLOBS", str(blobs)).replace("SMALL", str(small)) for word in arguments))
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.output
    assert not result.stdout or "--json" in arguments


def test_bars_are_for_terminals(blobs: Path, tmp_path: Path) -> None:
    for words in (
        ("robust", "edge", "--draws", "1", "--json"),
        ("run", "edge", str(blobs), "--trajectory", str(tmp_path / "w.gif")),
    ):
        result = _call(*words)
        assert result.exit_code == 0
        assert result.stdout.strip() == result.stdout.rstrip("\n")  # no empty line before
        assert not result.stderr


def test_a_network_that_does_not_settle_keeps_its_picture(blobs: Path, tmp_path: Path) -> None:
    out = tmp_path / "unsettled.png"
    result = _call("run", "connected-components-horizontal", blobs, "-o", out, "--boundary", "periodic")
    assert result.exit_code == 2
    assert "has not settled" in result.stderr
    assert out.exists()


def test_programs_are_listed_and_found_in_own_libraries(tmp_path: Path) -> None:
    text = (library.folder() / "programs" / "opening.toml").read_text()
    (tmp_path / "programs").mkdir()
    (tmp_path / "programs" / "mine.toml").write_text(text.replace('"opening"', '"mine"'))
    picture = tmp_path / "in.png"
    write_picture(np.ones((5, 6)), picture)
    listed = _call("--library", str(tmp_path), "list", "--programs")
    assert "picture -> opened" in listed.output
    assert f"[{(tmp_path / 'programs' / 'mine.toml').resolve()}]" in listed.output
    found = _call("--library", str(tmp_path), "list", "--programs", "--json")
    assert {"mine", "skeleton", "life"} <= {entry["name"] for entry in json.loads(found.output)}
    ran = _call("--library", str(tmp_path), "program", "mine", "--input", f"picture={picture}")
    assert "opened: 30 black cells" in ran.output


def test_a_sequence_is_traced_and_seen_to_its_end(tmp_path: Path) -> None:
    """A bar moves by one column a frame: at the end of the third frame its leading edge is that of the third."""
    files = []
    for frame in range(3):
        drawn = np.full((7, 10), -1.0)
        drawn[1:6, 2 + frame : 4 + frame] = 1.0
        files.append(str(tmp_path / f"{frame}.png"))
        write_picture(drawn, files[-1])
    answer = _call("trace", "moving-parts", *files, "--cell", "3,5", "--cell", "3,4", "--json")
    data = json.loads(answer.output)
    assert data["t"][-1] == 30
    assert [cell["x"][-1] > 0 for cell in data["cells"]] == [True, False]
