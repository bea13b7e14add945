"""Plots go into axes that are given, or make some, and return them; notebooks get short texts and pictures."""

from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

import cnnsim
from cnnsim import InputError, plot
from cnnsim.prototyping.design.decompose import design_rule
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.robust.margin import Margin
from cnnsim.prototyping.robust.report import Curve, Robustness
from cnnsim.prototyping.robust.robust import measure

PICTURE = np.where(np.random.default_rng(0).random((9, 12)) > 0.5, 1.0, -1.0)
RESULT = cnnsim.run("hole-filler", PICTURE, backend="reference", record=[0, 0.5, 1, 4])
PATHS = cnnsim.run("hole-filler", PICTURE, backend="reference", record=[(0, 0), (4, 5)])
ROBUST = measure(cnnsim.library.load("edge"), draws=1)
DESIGN = design_rule(parse_rule("c xor n"), "sum")


@pytest.fixture
def axes() -> Axes:
    mpl.use("agg")
    return Figure().add_subplot()


def test_axes_that_are_given_are_drawn_into(axes: Axes) -> None:
    trajectory, paths = RESULT.trajectory, PATHS.trajectory
    assert trajectory is not None
    assert paths is not None
    assert RESULT.plot(axes) is axes
    assert np.array_equal(np.asarray(axes.images[0].get_array()), RESULT.y)
    for drawn in (
        plot.plane(PICTURE, axes), plot.template(RESULT.plan.template, axes), trajectory.plot(axes),
        trajectory.plot(axes, cells=[(1, 2)]), paths.plot(axes), ROBUST.plot(axes, "noise"),
        plot.outputs(paths.t, paths.y, axes=axes),
    ):  # fmt: skip
        assert drawn is axes
    line = paths.plot(Figure().add_subplot()).lines[1]
    assert np.array_equal(np.asarray(line.get_ydata()), paths.x[:, 1])


def test_axes_are_made_where_none_are_given() -> None:
    from matplotlib import pyplot

    mpl.use("agg")
    assert isinstance(plot.plane(PICTURE), Axes)
    assert isinstance(ROBUST.plot(), Axes)
    pyplot.close("all")


@pytest.mark.parametrize("draw", [plot.states, plot.outputs])
def test_twenty_cells_look_different(axes: Axes, draw: Any) -> None:
    """The ninth had the colour and the line of the first."""
    t, x = np.linspace(0, 1, 5), np.zeros((5, 20))
    looks = {(line.get_color(), str(line._unscaled_dash_pattern)) for line in draw(t, x, axes=axes).lines}
    assert len(looks) == 20


def test_an_animation_shows_each_time(tmp_path: Path, axes: Axes) -> None:
    trajectory = RESULT.trajectory
    assert trajectory is not None
    film = trajectory.animate(axes)
    film.save(str(tmp_path / "film.gif"), writer="pillow")
    with Image.open(tmp_path / "film.gif") as image:
        assert getattr(image, "n_frames", 1) == 4
    assert axes.get_title() == "t = 4"
    assert PATHS.trajectory is not None
    with pytest.raises(InputError, match="record times instead"):
        PATHS.trajectory.animate(axes)


def test_a_plane_is_no_grey_picture_and_no_line(axes: Axes) -> None:
    with pytest.raises(InputError, match="from_gray"):
        plot.plane(np.full((3, 3), 200), axes)
    with pytest.raises(InputError, match=r"shape \(4,\)"):
        plot.plane(np.zeros(4), axes)
    assert np.asarray(plot.plane(np.eye(3, dtype=bool), axes).images[-1].get_array())[0].tolist() == [1, -1, -1]


def test_texts_are_short_and_say_what_there_is() -> None:
    edge = cnnsim.library.load("edge")
    assert repr(edge.template) == (
        "Template('edge', A=[[0, 0, 0], [0, 1, 0], [0, 0, 0]], B=[[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]], z=-1)"
    )
    assert "<11 x 11, 121 not zero>" in repr(cnnsim.Template(np.ones((11, 11)), name="large"))
    text = repr(RESULT)
    assert len(text) < 250
    assert "'hole-filler', t = " in text
    assert f"{(RESULT.y > 0).sum()} black" in text
    for value in (RESULT.trajectory, cnnsim.load_program("slip-front"), ROBUST, DESIGN, edge, RESULT.plan):
        assert len(repr(value)) < 500, value


def test_notebooks_get_html_and_pictures() -> None:
    program = cnnsim.load_program("maze-shortest-path")
    layers = cnnsim.library.load("autowave")
    shown = (RESULT, RESULT.trajectory, PATHS.trajectory, RESULT.plan.template, program, ROBUST, DESIGN, layers)
    for value in shown:
        html = value._repr_html_()  # type: ignore[union-attr]
        assert html.count("<table") == html.count("</table>")
        assert html.count("<div>") == html.count("</div>")
    assert "until" in program._repr_html_()
    for value in (RESULT, RESULT.trajectory, PATHS.trajectory, RESULT.plan.template, ROBUST):
        with Image.open(BytesIO(value._repr_png_())) as image:  # type: ignore[union-attr]
            assert image.width > 100
            assert len(np.unique(np.asarray(image.convert("L")))) > 1


def test_outputs_of_a_program_are_a_strip_of_pictures_and_numbers() -> None:
    outputs = cnnsim.run_program("count-objects", picture=PICTURE, backend="reference")
    assert isinstance(outputs, dict)
    html = outputs._repr_html_()
    pictures = sum(np.ndim(value) == 2 for value in outputs.values())
    assert html.count("<img") == pictures
    assert "objects" in html
    assert "guaranteed time" in repr(cnnsim.explain("hole-filler", PICTURE))  # the plan as text


def test_html_of_strange_names_is_text() -> None:
    assert "<script>" not in cnnsim.Template(1.0, name="<script>")._repr_html_()


@pytest.mark.parametrize("side", [1, 3, 5, 7, 11])
def test_numbers_of_a_template_have_room(side: int) -> None:
    """They do not run into one another: of large matrices there are the colours alone."""
    entries = -np.random.default_rng(side).uniform(1e-3, 1e-1, (side, side))
    figure = Figure((6.0, 3.2), layout="constrained")
    axes = plot.template(cnnsim.Template(entries, entries, 0.25, name="x" * 90), figure.add_subplot())
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == (2 if side == 11 else 2 + 2 * side**2)
    assert not any(a.overlaps(b) for number, a in enumerate(boxes) for b in boxes[:number])
    assert axes.title.get_window_extent().width < figure.bbox.width


def test_a_template_says_its_terms() -> None:
    median = cnnsim.library.load("median").network
    assert repr(median).endswith("z=0, 1 term)")
    assert isinstance(median, cnnsim.Template)
    assert cnnsim.plot.template(median).get_title() == "median, z = 0, 1 term"


def test_what_cannot_be_drawn_into_or_at_all_is_told() -> None:
    paths, trajectory = PATHS.trajectory, RESULT.trajectory
    assert paths is not None
    assert trajectory is not None
    with pytest.raises(InputError, match="axes 3; Axes of matplotlib wanted"):
        RESULT.plot(3)  # type: ignore[arg-type]  # as a user might
    with pytest.raises(InputError, match="no cells"):
        paths.plot(cells=[])
    for interval in (-1.0, float("nan")):
        with pytest.raises(InputError, match=r"interval .* a positive number wanted"):
            trajectory.animate(interval=interval)


def test_the_key_of_a_robustness_plot_lies_beside_its_curves() -> None:
    """It lay on the curve of templates that fail early."""
    bad = Curve((0.001, 0.01, 0.1), (0.5, 0.5, 0.5), (0.9, 0.9, 0.9))
    bits = Curve((12, 3), (0.4, 0.5), (0.4, 0.5))
    found = Robustness("x", Margin(0.1, 0.0012, True, ""), "all", bad, bits, bad, 3, 0)
    figure = found.figure()
    figure.draw_without_rendering()
    (key,) = figure.legends
    texts = [text.get_text() for text in key.get_texts()]
    assert "mean" in texts
    assert "errors up to 0.12 % are harmless" in texts  # next to its line it was cut off at the left
    around = key.get_window_extent()
    for axes in figure.axes:
        assert not around.overlaps(axes.get_tightbbox())
        assert axes.get_legend() is None
    assert not any(around.overlaps(note.get_window_extent()) for note in figure.texts)


def test_layers_are_numbered() -> None:
    turning = cnnsim.run("autowave", PICTURE, backend="reference", duration=1.0)
    axes = turning.plot(Figure().add_subplot())
    assert [label.get_text() for label in axes.get_xticklabels()] == [str(n) for n in range(len(turning.y))]
    cols = PICTURE.shape[1]
    assert list(axes.get_xticks()) == [cols / 2 - 0.5 + n * cols for n in range(len(turning.y))]
    assert axes.get_xlabel() == "layer"
    alone = RESULT.plot(Figure().add_subplot())
    assert list(alone.get_xticks()) == []
    assert alone.get_xlabel() == ""
