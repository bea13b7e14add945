"""Recorded transients: the states are those of the machine, and the command writes what it promises."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from PIL import Image

from cnnsim import backends, library, write_picture
from cnnsim.cli.trace import trace
from cnnsim.network.cell import output, uncoupled_state
from cnnsim.prototyping.trace.plot import draw_trace, given_pictures
from cnnsim.prototyping.trace.trace import parse_cell_index, record, representative_cells, watching_time
from cnnsim.support import InputError
from cnnsim.support.pictures.film import BETWEEN, STRIP, write_film
from cnnsim.task import Task, make_task
from cnnsim.trajectories import SHEET, Trajectory, sheet_frames
from cnnsim.transient import run_transient


def task_of(name: str, **changes: object) -> Task:
    entry = library.load(name)
    example = entry.examples[0]
    assert example.input is not None
    given = {"boundary": entry.boundary, "duration": entry.duration, **changes}
    return make_task(entry.template, **entry.planes(example.input), **given)  # type: ignore[arg-type]


@pytest.mark.parametrize("scheme", [None, "euler", "rk4"])
def test_the_last_state_is_that_of_a_plain_run(scheme: str | None) -> None:
    task = task_of("hole-filler", duration=3.0, scheme=scheme)
    found = record(task, backends.get("reference"), 3.0, 30)
    assert found.t == pytest.approx(np.arange(31) / 10)
    assert np.array_equal(found.x[0], task.state)
    end = run_transient(task.plan.template, state=task.state, input=task.input, boundary=task.plan.boundary,
                        duration=3.0, scheme=scheme, backend="reference").x  # fmt: skip
    assert np.allclose(found.x[-1], end, atol=1e-12)
    assert np.abs(found.y).max() == 1.0


def test_cells_without_neighbours_follow_the_closed_form() -> None:
    task = task_of("edge")
    found = record(task, backends.get("reference"), 1.5, 15)
    s = record(task, backends.get("reference"), 1e-6, 1).x[1] / 1e-6  # x(0) = 0, a = 1: the slope at 0 is s
    for frame in (3, 15):
        assert np.allclose(found.x[frame], uncoupled_state(task.state, s, 1.0, found.t[frame], "chua-yang"), atol=1e-4)


def test_it_is_watched_until_outputs_stand_still() -> None:
    backend = backends.get("reference")
    for name in ("hole-filler", "edge"):
        task = task_of(name)
        found = record(task, backend, watching_time(task, backend), 40)
        final = run_transient(task.plan.template, state=task.state, input=task.input, boundary=task.plan.boundary).y
        assert np.allclose(found.y[-1], final, atol=1e-6)
    assert watching_time(task_of("hole-filler", duration=2.5), backend) == 2.5


def test_telling_cells_go_different_ways() -> None:
    t = np.linspace(0, 1, 11)
    x = np.zeros((11, 2, 3))
    x[:, 0, 0] = 5 * t
    x[:, 1, 2] = -3 * t
    x[:, 1, 1] = 5 * t
    assert representative_cells(Trajectory(t, x, output(x)), most=3) in (
        [(0, 0), (1, 2), (0, 1)],
        [(0, 1), (0, 0), (1, 2)],
    )
    assert representative_cells(Trajectory(t, x, output(x)), most=5) == representative_cells(
        Trajectory(t, x, output(x)), most=3
    )  # the rest repeats them
    assert representative_cells(Trajectory(t, 0 * x, 0 * x)) == [(0, 0)]


def test_the_contact_sheet_shows_the_time_in_which_something_happens() -> None:
    x = np.zeros((101, 1, 1))
    x[:, 0, 0] = np.minimum(np.arange(101) / 20, 1)
    frames = sheet_frames(output(x))
    assert frames[0] == 0
    assert frames[-1] == 20
    assert len(frames) == SHEET


@pytest.mark.parametrize(("name", "layer"), [("autowave", 0), ("autowave", 1), ("median", 0), ("discrete-edge", 0)])
def test_other_kinds_of_template_are_traced_as_well(name: str, layer: int) -> None:
    entry = library.load(name)
    picture = entry.examples[0].input if entry.examples[0].state is None else entry.examples[0].state
    assert picture is not None
    task = make_task(entry.network, **{**entry.task(picture), "duration": 4.0})
    found = record(task, backends.get("reference"), 4.0, 4, layer)
    assert found.t == pytest.approx(np.arange(5))
    end = library.run(entry, picture, backend="reference", duration=4.0)
    assert np.allclose(found.x[-1], end.x[layer] if end.x.ndim == 3 else end.x, atol=1e-9)
    assert np.allclose(found.y[-1], end.y[layer] if end.x.ndim == 3 else end.y, atol=1e-9)


@pytest.mark.parametrize(("name", "said"), [("autowave", "Layer 1 of 0 to 1."), ("edge", "")])
def test_the_layer_that_is_drawn_is_named(
    name: str, said: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    drawn: list[Figure] = []
    save = Figure.savefig

    def kept(figure: Figure, *where: Any, **how: Any) -> None:
        drawn.append(figure)
        save(figure, *where, **how)

    monkeypatch.setattr(Figure, "savefig", kept)
    entry = library.load(name)
    task = make_task(entry.network, **{**entry.task(2 * np.eye(5) - 1), "duration": 1.0})
    layer = 1 if said else 0
    found = record(task, backends.get("reference"), 1.0, 2, layer)
    draw_trace(found, [(0, 0)], "a title.", tmp_path / "x.png", task, layer)
    assert drawn[0].get_suptitle() == f"a title. {said}".strip()


def test_a_layer_that_is_not_there() -> None:
    with pytest.raises(InputError, match="layer 1; 0 to 0"):
        record(task_of("edge"), backends.get("reference"), 1.0, 2, 1)


@pytest.mark.parametrize("text", ["3", "a,b", "-1,0", "0,9", "1,2,3", ""])
def test_a_cell_that_is_none(text: str) -> None:
    with pytest.raises(InputError, match="cell"):
        parse_cell_index(text, (4, 9))


def test_a_cell_is_row_then_column() -> None:
    assert parse_cell_index("3,8", (4, 9)) == (3, 8)


def test_the_command(tmp_path: Path) -> None:
    picture, plot, film = tmp_path / "in.png", tmp_path / "trace.png", tmp_path / "film.gif"
    drawn = library.load("hole-filler").examples[0].input
    assert drawn is not None
    write_picture(drawn, picture)
    options = ["--cell", "3,3", "--cell", "0,0", "--frames", "20", "-o", str(plot), "--film", str(film)]
    result = CliRunner().invoke(trace, ["hole-filler", str(picture), *options])
    assert result.exit_code == 0, result.output
    assert "(3, 3) (0, 0)" in result.output
    with Image.open(plot) as image:
        assert image.width > 800
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20
    with Image.open(film) as image:
        assert getattr(image, "n_frames", 1) > 2
    answer = CliRunner().invoke(trace, ["hole-filler", str(picture), "--cell", "0,0", "--time", "2", "--json"])
    data = json.loads(answer.output)
    assert data["t"][-1] == 2.0
    assert data["cells"][0]["x"][0] == 1.0
    assert data["cells"][0]["x"][-1] < -1


def test_the_command_with_nothing_to_write(tmp_path: Path) -> None:
    result = CliRunner().invoke(trace, ["edge", str(tmp_path / "none.png")])
    assert isinstance(result.exception, InputError)


def test_what_was_given_is_drawn() -> None:
    assert [name for name, _ in given_pictures(task_of("hole-filler"))] == ["input u"]
    two = library.load("recall")
    picture, marker = two.examples[0].input, two.examples[0].state
    assert picture is not None
    assert marker is not None
    drawn = given_pictures(make_task(two.network, **two.task(picture, marker)))
    assert [name for name, _ in drawn] == ["input u", "initial state x(0)"]
    assert np.array_equal(drawn[0][1], picture)
    assert np.array_equal(drawn[1][1], marker)
    wave = library.load("autowave")
    assert [name for name, _ in given_pictures(make_task(wave.network, **wave.task(picture)), 1)] == [
        "initial state x(0)"
    ]
    moving = library.load("moving-parts")
    (name, first), *_ = given_pictures(make_task(moving.network, **moving.task(np.stack([picture, -picture]))))
    assert name == "input u, the first of 2"
    assert np.array_equal(first, picture)


def test_a_film_has_its_times_below_the_cells(tmp_path: Path) -> None:
    frames = [np.full((8, 16), value) for value in (-1.0, 0.0, 1.0)]
    write_film(frames, tmp_path / "film.gif", times=[0, 1.25, 10])
    with Image.open(tmp_path / "film.gif") as film:
        pictures = []
        for number in range(3):
            film.seek(number)
            pictures.append(np.asarray(film.convert("L")))
    for picture, grey in zip(pictures, (255, 128, 0), strict=True):
        assert abs(int(picture[0, 0]) - grey) <= 1
        assert len(np.unique(picture[:-STRIP])) == 1  # nothing is written onto the cells
    strips = [picture[-STRIP + 1 :].tobytes() for picture in pictures]
    assert len(set(strips)) == 3


def test_a_film_of_layers_names_each_below_its_own_cells(tmp_path: Path) -> None:
    """Also where a layer is narrower than its name; between layers of one grey a line is seen."""
    for shape in ((2, 8, 16), (3, 300, 2)):
        frames = [np.full(shape, 1.0), np.full(shape, -1.0)]
        write_film(frames, tmp_path / "film.gif", times=[0, 1])
        with Image.open(tmp_path / "film.gif") as film:
            film.seek(1)
            white = np.asarray(film.convert("L")) < 100
        width = (white.shape[1] + BETWEEN) // shape[0]
        for layer in range(shape[0]):
            name = white[-2 * STRIP + 1 : -STRIP, layer * width : (layer + 1) * width - BETWEEN]
            assert name.any()
            assert not white[: -2 * STRIP, layer * width : (layer + 1) * width - BETWEEN].any()  # nothing on cells
            assert layer == 0 or white[: -2 * STRIP, layer * width - BETWEEN : layer * width].any()
