"""Sequences of pictures through the commands: every picture, in order, from every kind of source."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from cnnsim import UniversalMachine, load_program, read_picture, read_pictures, write_picture
from cnnsim.cli.group import main
from cnnsim.support.extras import install_line
from cnnsim.support.pictures.film import filming, write_film
from tests.kits.paths import ROOT


def call(*arguments: Any) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def moving_bar(count: int = 12) -> np.ndarray:
    """A bar that moves by a column a picture; the picture's number makes all pictures different."""
    pictures = np.full((count, 20, 24), -1.0)
    for number, picture in enumerate(pictures):
        picture[3:12, number : number + 4] = 1.0
        picture[16, : number + 1] = 1.0
    return pictures


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bar").mkdir()
    for number, picture in enumerate(moving_bar()):
        write_picture(picture, tmp_path / "bar" / f"{number}.png")  # 10.png comes after 2.png
    (tmp_path / "bar" / "notes.txt").write_text("no picture")
    return tmp_path


def stepped(name: str, pictures: np.ndarray) -> list[dict[str, Any]]:
    machine, program = UniversalMachine(), load_program(name)
    return [machine.run(program, **{program.inputs[0]: picture}) for picture in pictures]


def test_repeated_inputs_are_steps_of_a_program_with_memory(folder: Path) -> None:
    inputs = [word for number in (3, 0, 1) for word in ("--input", f"frame=bar/{number}.png")]
    done = call("program", "motion-detection", *inputs, "-o", "out", "--json")
    assert done.exit_code == 0, done.output
    wanted = stepped("motion-detection", moving_bar()[[3, 0, 1]])
    for number, step in enumerate(wanted):
        for name in PLANES:
            assert np.array_equal(read_picture(f"out/{name}-{number:04d}.png") > 0, step[name] > 0)
    facts = json.loads(done.stdout)
    assert facts["steps"] == 3
    assert counts(facts) == counts_of(wanted)
    assert len(set(counts(facts)["appeared"])) > 1


PLANES = ("appeared", "vanished", "moving", "resting")


def counts(facts: dict[str, Any]) -> dict[str, list[int]]:
    """Black cells of each plane in each step, as a command printed them."""
    return {name: [step["black"] for step in facts["outputs"][name]] for name in PLANES}


def counts_of(steps: list[dict[str, Any]]) -> dict[str, list[int]]:
    """The same of what a machine gave."""
    return {name: [int((step[name] > 0).sum()) for step in steps] for name in PLANES}


def sources(folder: Path, kind: str) -> tuple[str, ...]:
    pictures = moving_bar()
    if kind == "files":
        return tuple(f"bar/{number}.png" for number in range(len(pictures)))
    if kind == "npy":
        np.save("bar.npy", pictures)
    elif kind == "npz":
        np.savez("bar.npz", frame=pictures, other=pictures[::-1])
    elif kind == "tif":
        images = [Image.fromarray(np.where(picture > 0, 0, 255).astype(np.uint8)) for picture in pictures]
        images[0].save("bar.tif", save_all=True, append_images=images[1:])
    elif kind != "folder":
        if kind == "mp4":
            pytest.importorskip("av")
        with filming(f"bar.{kind}", 5.0) as add:
            for picture in pictures:
                add(np.kron(picture, np.ones((4, 4))))  # a video blurs single pixels
    return ("bar",) if kind == "folder" else (f"bar.{kind}",)


@pytest.mark.parametrize("kind", ["files", "folder", "npy", "npz", "gif", "tif", "mp4"])
def test_every_source_gives_all_pictures_in_order(folder: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnnsim.support.pictures.film._WIDE", 1)  # nothing is enlarged
    inputs = [word for source in sources(folder, kind) for word in ("--input", f"frame={source}")]
    done = call("program", "motion-detection", *inputs, "--binary", "-o", "out", "--json")
    assert done.exit_code == 0, done.output
    scale = 4 if kind in ("gif", "mp4") else 1
    wanted = stepped("motion-detection", np.kron(moving_bar(), np.ones((1, scale, scale))))
    assert counts(json.loads(done.stdout)) == counts_of(wanted)
    assert len(list(Path("out").iterdir())) == 12 * len(PLANES)


@pytest.mark.parametrize("film", ["film.gif", "film.mp4"])
def test_results_as_a_film(folder: Path, film: str) -> None:
    if film.endswith("mp4"):
        pytest.importorskip("av")
    done = call("program", "motion-detection", "--input", "frame=bar", "-o", film)
    assert done.exit_code == 0, done.output
    path = film.replace(".", "-appeared.")
    assert f"-> {path}" in done.output
    found = read_pictures(path, binary=True)
    scale = found.shape[1] // 20
    wanted = np.array([step["appeared"] > 0 for step in stepped("motion-detection", moving_bar())])
    if film.endswith("gif"):  # equal pictures that follow one another are one that stands longer
        wanted = wanted[[True, *(wanted[1:] != wanted[:-1]).any(axis=(1, 2))]]
    assert len(found) == len(wanted)
    assert np.array_equal(found[:, scale // 2 :: scale, scale // 2 :: scale] > 0, wanted)


TWO_INPUTS = """
name = "both"
llm = ["a", "b", "c"]
inputs = ["a", "b"]
outputs = ["c"]
[[step]]
logic = "and"
of = ["a", "b"]
to = "c"
"""


def test_sequences_of_two_lengths_are_refused_with_both(folder: Path) -> None:
    (folder / "both.toml").write_text(TWO_INPUTS)
    a = [word for number in range(3) for word in ("--input", f"a=bar/{number}.png")]
    done = call("program", "both.toml", *a, "--input", "b=bar", "-o", "out")
    assert done.exit_code == 2
    assert "a has 3 pictures, b has 12 pictures" in done.stderr
    assert not (folder / "out").exists()
    done = call("program", "both.toml", *a, "--input", "b=bar/0.png")
    assert "a has 3 pictures, b has 1 picture;" in done.stderr
    done = call("program", "both.toml", *a, "--still", "b=bar/0.png", "--json")
    black = [step["black"] for step in json.loads(done.stdout)["outputs"]["c"]]
    assert black == [int(((moving_bar()[n] > 0) & (moving_bar()[0] > 0)).sum()) for n in range(3)]
    done = call("program", "both.toml", *a, "--still", "b=bar")
    assert "--still b: 12 pictures; a single one wanted" in done.stderr


def test_one_video_of_two_is_shorter(folder: Path) -> None:
    pytest.importorskip("av")
    (folder / "both.toml").write_text(TWO_INPUTS)
    write_film(list(moving_bar(12)), "a.mp4")
    write_film(list(moving_bar(9)), "b.mp4")
    done = call("program", "both.toml", "--input", "a=a.mp4", "--input", "b=b.mp4")
    assert "a has 12 pictures, b has 9 pictures" in done.stderr


def test_pictures_of_two_sizes_are_refused_before_anything_runs(folder: Path) -> None:
    write_picture(np.ones((5, 6)), "bar/7.png")
    done = call("program", "motion-detection", "--input", "frame=bar", "-o", "out")
    assert done.exit_code == 2
    assert "bar/0.png is 20 x 24, bar/7.png 5 x 6" in done.stderr
    assert not (folder / "out").exists()


def test_a_single_picture_of_a_file_of_many_is_asked_for(folder: Path) -> None:
    sources(folder, "gif")
    with pytest.raises(ValueError, match=r"bar.gif holds 12 pictures; one wanted"):
        read_picture("bar.gif")


def test_a_template_runs_on_each_picture_by_itself(folder: Path) -> None:
    done = call("run", "edge", "bar", "-o", "edge.png", "--json")
    assert done.exit_code == 0, done.output
    for number in range(12):
        call("run", "edge", f"bar/{number}.png", "-o", "alone.png", "--replace")
        assert np.array_equal(read_picture(f"edge-{number}.png"), read_picture("alone.png"))
    assert json.loads(done.stdout)["shape"] == [12, 20, 24]
    done = call("run", "edge", "bar", "-o", "edges.gif")
    assert done.output.strip().endswith("-> edges.gif")
    with Image.open("edges.gif") as film:
        assert film.n_frames == 12  # type: ignore[attr-defined]  # GIFs have frames


def test_a_template_for_moving_pictures_takes_a_film(folder: Path) -> None:
    files = [f"bar/{number}.png" for number in range(12)]
    one = call("run", "moving-parts", *files, "-o", "one.png")
    two = call("run", "moving-parts", "bar", "-o", "two.png")
    assert one.exit_code == two.exit_code == 0, two.output
    assert np.array_equal(read_picture("one.png"), read_picture("two.png"))


def test_second_pictures_are_one_or_as_many(folder: Path) -> None:
    seed = -np.ones((20, 24))
    seed[3:12, 3] = 1
    write_picture(seed, "seed.png")
    done = call("run", "recall", "bar", "--state", "seed.png", "--json")
    assert done.exit_code == 0, done.output
    done = call("run", "recall", "bar", "--state", "bar")
    assert done.exit_code == 0, done.output
    (folder / "two").mkdir()
    write_picture(seed, "two/0.png")
    write_picture(seed, "two/1.png")
    done = call("run", "recall", "bar", "--state", "two")
    assert "--state: 2 pictures for 12; one or 12 wanted" in done.stderr


def test_broken_and_empty_sources(folder: Path) -> None:
    (folder / "empty").mkdir()
    (folder / "film.mp4").write_bytes(b"no video")
    for source, words in (
        ("empty", "the folder empty holds no picture"),
        ("none.mp4", "no video none.mp4"),
        ("none.npz", "no array file none.npz"),
        ("none.png", "no picture none.png"),
    ):
        done = call("program", "motion-detection", "--input", f"frame={source}")
        assert done.exit_code == 2
        assert words in done.stderr
    pytest.importorskip("av")
    done = call("program", "motion-detection", "--input", "frame=film.mp4")
    assert done.exit_code == 2
    assert "film.mp4: cannot be read as a video" in done.stderr


def test_a_video_without_pyav_says_what_to_install(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "film.mp4").write_bytes(b"x")
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    done = call("program", "motion-detection", "--input", "frame=film.mp4")
    assert done.exit_code == 2
    assert f"film.mp4: a video needs PyAV: {install_line('video')}" in done.stderr


def test_the_shipped_programs_for_sequences_run_on_a_folder(folder: Path) -> None:
    assert (ROOT / "templates" / "programs" / "motion-direction.toml").is_file()
    done = call("program", "motion-direction", "--input", "frame=bar", "-o", "out")
    assert done.exit_code == 0, done.output
    assert done.output.startswith("motion-direction: 12 steps")
