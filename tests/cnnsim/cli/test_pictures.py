"""Pictures on the command line: masks, bias maps and the range of their levels."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

import cnnsim
from cnnsim import read_picture, write_picture
from cnnsim.cli.group import main
from cnnsim.support.pictures.film import BETWEEN, STRIP


def call(*arguments: Any) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_masks_and_bias_maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mask keeps cells as they start; a bias of +1 over EDGE's z of -1 makes lone windows black, see the oracle."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    picture = np.where(rng.random((20, 24)) < 0.5, 1.0, -1.0)
    keep = np.zeros((20, 24), bool)
    keep[:, :7] = True
    write_picture(picture, "in.png")
    write_picture(keep, "keep.png")
    done = call("run", "hole-filler", "in.png", "--mask", "keep.png", "-o", "out.png", "--boundary", "fixed:0")
    assert done.exit_code == 0, done.output
    found = read_picture("out.png")
    assert np.all(found[:, :7] == 1)  # x(0) = 1 is what they keep
    assert np.any(found[:, 7:] == -1)
    np.save("bias.npy", np.where(keep, 0.0, 1.0))
    done = call("run", "threshold-zero", "in.png", "--bias", "bias.npy", "-o", "lifted.png")
    assert done.exit_code == 0, done.output
    lifted = read_picture("lifted.png") > 0
    assert np.array_equal(lifted[:, :7], picture[:, :7] > 0)
    write_picture(np.ones((4, 4)), "small.png")
    for option in ("--mask", "--bias"):
        done = call("run", "hole-filler", "in.png", option, "small.png")
        assert done.exit_code == 2
        assert f"{option} has shape (4, 4), the picture (20, 24); one shape wanted" in done.stderr


def test_an_array_of_truth_values_as_floats_is_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a line: 0 is mid-grey, where nearly always white is meant."""
    monkeypatch.chdir(tmp_path)
    np.save("x.npy", np.pad(np.ones((3, 3)), 2))
    done = call("run", "edge", "x.npy", "-o", "edge.png")
    assert done.exit_code == 0
    assert done.stderr.startswith("picture holds 0 and 1 alone; template 'edge' takes -1 as white")
    assert done.stderr.count("\n") == 1
    assert call("run", "edge", "x.npy", "-o", "right.png", "--range", "1,0").exit_code == 0
    assert (read_picture("right.png") > 0).sum() == 8


@pytest.mark.parametrize("ending", ["png", "tif", "npy"])
def test_sixteen_bits_of_which_few_are_used(ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """12 bits in a file of 16 are nearly black: read so, but not without a word."""
    monkeypatch.chdir(tmp_path)
    file, depth = f"depth-{ending}.{ending}", np.array([[0, 1000, 4095]], np.uint16)
    if ending == "npy":
        np.save(file, depth)
    else:
        Image.fromarray(depth).save(file)
    done = call("run", "threshold-zero", file)
    assert done.exit_code == 0
    assert "its largest number is 4095 of 65535, so the picture is nearly black" in done.stderr
    assert "if 4095 is white, use --range 0,4095" in done.stderr
    assert "nearly black" not in call("run", "threshold-zero", file, "--range", "0,4095").stderr


def test_levels_are_told_on_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.array([[0, 4095], [1000, 3000]], np.uint16)).save("camera.png")
    call("run", "threshold-zero", "camera.png", "--range", "0,4095", "-o", "out.png")
    assert (read_picture("out.png") > 0).tolist() == [[True, False], [True, False]]
    done = call("run", "threshold-zero", "camera.png", "--range", "0")
    assert "range '0'; BLACK,WHITE wanted" in done.stderr
    done = call("run", "threshold-zero", "camera.png", "--range", "0,1000")
    assert "from 0 to 4095; 0 (black) to 1000 wanted" in done.stderr


def test_several_results_go_into_a_folder_and_older_ones_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in "abc":
        write_picture(np.ones((5, 6)), f"{name}.png")
    done = call("run", "threshold-zero", "a.png", "b.png", "c.png", "-o", "many")
    assert " ".join(done.stdout.split()).endswith("-> many/threshold-zero-0.png to many/threshold-zero-2.png")
    done = call("run", "threshold-zero", "a.png", "b.png", "-o", "many", "--replace")
    assert " ".join(done.stdout.split()).endswith("; of an earlier run: many/threshold-zero-2.png")
    assert call("run", "threshold-zero", "a.png", "-o", "many/").exit_code == 0
    assert read_picture("many/threshold-zero.png").shape == (5, 6)


def test_a_film_of_two_layers_shows_them_side_by_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_picture(np.eye(16), "one.png")
    assert call("run", "autowave", "one.png", "--trajectory", "film.gif").exit_code == 0
    with Image.open("film.gif") as film:
        side = film.height - 2 * STRIP  # below the cells the layer, below that the time
        assert film.width == 2 * side + BETWEEN


def test_grey_results_are_saved_without_loss(tmp_path: Path) -> None:
    """As numbers, 16-bit levels and floats; the picture that is read again has the values of the run."""
    picture = tmp_path / "p.png"
    cnnsim.write_picture(np.random.default_rng(3).random((6, 7)) > 0.5, picture)
    y = cnnsim.run("diffusion", cnnsim.read_picture(picture), backend="reference", duration=1.0).y
    how = ["run", "diffusion", str(picture), "--time", "1", "--backend", "reference", "-o"]
    for name, bits, allowed in (
        ("y.npy", 8, 1e-15), ("y.npz", 8, 1e-15), ("y.png", 16, 2**-15), ("y.tif", 16, 2**-15), ("f.tiff", 32, 2**-23),
    ):  # fmt: skip
        done = CliRunner().invoke(main, [*how, str(tmp_path / name), "--bits", str(bits)])
        assert done.exit_code == 0, done.output
        assert np.abs(cnnsim.read_picture(tmp_path / name) - y).max() <= allowed, name
    done = CliRunner().invoke(main, [*how, str(tmp_path / "y.jpg"), "--bits", "16"])
    assert done.exit_code == 2
    assert "16 bits a grey level; 8 wanted, or 16: .png, .tif, .tiff" in done.output
    program = [
        "program",
        "gray-opening",
        "--input",
        f"picture={picture}",
        "--format",
        "npy",
        "-o",
        str(tmp_path / "out"),
    ]
    assert CliRunner().invoke(main, program).exit_code == 0
    assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".npy"}


def test_states_over_time_are_saved_as_numbers(tmp_path: Path) -> None:
    cnnsim.write_picture(np.eye(5) > 0, tmp_path / "p.png")
    path = tmp_path / "states.npz"
    how = ["--time", "2", "--frames", "4", "--backend", "reference", "-o", str(path)]
    done = CliRunner().invoke(main, ["trace", "diffusion", str(tmp_path / "p.png"), *how])
    assert done.exit_code == 0, done.output
    with np.load(path) as found:
        assert found["x"].shape == found["y"].shape == (5, 5, 5)
        assert np.allclose(found["t"], [0, 0.5, 1, 1.5, 2])


def test_floats_from_0_to_1_give_a_warning_with_the_conversion() -> None:
    grey = np.random.default_rng(1).random((6, 6))
    with pytest.warns(UserWarning, match=r"lies from 0 to 1.*from_gray\(values, 1\) converts"):
        cnnsim.run("diffusion", grey, backend="reference", duration=0.1)
    dark = cnnsim.from_gray(np.arange(36).reshape(6, 6) * 3)  # of an 8-bit picture, and no warning
    cnnsim.run("diffusion", dark, backend="reference", duration=0.1)
