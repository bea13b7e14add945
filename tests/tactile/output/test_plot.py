"""The figure of a run: axis limits, arrow scale, label positions, marks of uncertain loads and missing readings."""

import csv
import itertools
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver, QuiverKey

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected
from tactile.output.plot import draw, draw_run
from tactile.output.plot_events import short_words
from tactile.output.record import RunRecord
from tactile.pipeline import FrameReport, run
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.paths import SCENES


def pressed(side: int, normal: float = 0.5, shear: float = 0.0, frames: int = 60) -> FrameStream:
    array = TaxelArray("pad", side, side, 1e-3, 0.0, quantity="force")
    values = np.zeros((side, side, 3))
    values[side // 2, side // 2] = [shear, 0.0, normal]
    stream = [Frame(0, n / 100, n, values, np.ones((side, side), bool)) for n in range(frames)]
    return FrameStream("pad", (array,), None, frames, stream)


def drawn(source: Any, settings: Settings | None = None) -> tuple[Any, Collected]:
    collected = Collected()
    run(source, settings or Settings(backend="reference"), [collected])
    return picture(collected, source.arrays, source.title), collected


def picture(collected: Collected, arrays: tuple[TaxelArray, ...], title: str) -> Any:
    figure = Figure()
    draw_run(figure, collected, arrays, title)
    return figure


def axis(figure: Any, name: str) -> Any:
    return next(one for one in figure.axes if one.get_ylabel().startswith(name))


def quiver(plane: Any) -> Any:
    (arrows,) = (one for one in plane.collections if isinstance(one, Quiver))
    return arrows


def test_a_constant_signal_has_sensible_limits() -> None:
    figure, _ = drawn(pressed(3))
    normal = axis(figure, "normal [N]")
    low, high = normal.get_ylim()
    assert high - low > 0.05
    assert low < 0.5 < high
    figure.draw_without_rendering()
    assert normal.yaxis.get_offset_text().get_text() == ""
    low, high = axis(figure, "shear").get_ylim()
    assert high - low > 0.05


@pytest.mark.parametrize(("shear", "key"), [(3e-3, 0.1), (0.3, 0.2), (1.0, 1.0), (7.0, 5.0)])
def test_the_key_states_the_scale_of_the_arrows(shear: float, key: float) -> None:
    """The longest arrow fits a taxel; arrows below the dead band stay short."""
    figure, _ = drawn(pressed(3, 1.0, shear))
    plane = axis(figure, "y [mm]")
    arrows = quiver(plane)
    key_of_arrows: Any = next(one for one in plane.artists if isinstance(one, QuiverKey))
    assert pytest.approx(key) == key_of_arrows.U
    assert key_of_arrows.text.get_text() == f"shear {key:g} N"
    width = np.ptp(plane.get_xlim())  # [mm], and the pitch is 1 mm
    length = np.hypot(arrows.U, arrows.V).max() / arrows.scale * width
    assert length == pytest.approx(0.85 * min(1.0, shear / 0.1), rel=1e-6)
    assert ("below the dead band" in plane.get_title(loc="left")) == (shear < 0.1)


@pytest.mark.parametrize(("side", "squares"), [(8, 1), (32, 0), (64, 0)])
def test_large_arrays_have_no_grid_and_few_arrows(side: int, squares: int) -> None:
    plane = axis(drawn(pressed(side))[0], "y [mm]")
    assert sum(isinstance(one, PatchCollection) for one in plane.collections) == squares
    arrows = quiver(plane)
    assert arrows.U.size <= 16**2
    assert plane.get_title(loc="left").startswith(f"{side} x {side} taxels")


def test_fingers_share_their_scales() -> None:
    """Two fingers with forces of 1 N and 4 N: limits, colours and arrows are the same."""
    arrays = tuple(TaxelArray(name, 2, 2, 1e-3, 0.0, quantity="force") for name in ("weak", "strong"))
    values = np.ones((2, 2, 3))
    frames = [Frame(n % 2, n / 200, n // 2, values * (4 if n % 2 else 1), np.ones((2, 2), bool)) for n in range(80)]
    figure, _ = drawn(FrameStream("two", arrays, None, 80, frames))
    for name in ("normal [N]\n", "shear [N]\n"):
        one, other = (axis.get_ylim() for axis in figure.axes if axis.get_ylabel().startswith(name))
        assert one == other
    planes = [axis for axis in figure.axes if axis.get_ylabel() == "y [mm]"]
    assert len({plane.images[0].get_clim() for plane in planes}) == 1
    assert len({quiver(plane).scale for plane in planes}) == 1
    assert [len(plane.artists) for plane in planes] == [1, 0]  # one key


def test_events_are_bars_from_onset_to_end() -> None:
    """Their texts overlap neither each other nor a bar, and lie inside the axes."""
    figure, collected = drawn(open_source(SCENES / "grip.toml"))
    panel = next(axis for axis in figure.axes if axis.get_title(loc="left").startswith("left"))
    events = [event for event in collected.events if event.finger in ("left", "hand")]
    spans = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in panel.patches]
    assert np.allclose(sorted(spans), sorted((event.t, event.end) for event in events))
    names = [label.get_text() for label in panel.get_yticklabels()]
    assert names[:2] + names[-1:] == ["contact", "load", "hand: pull"]
    assert [text.get_text() for text in panel.texts] == [short_words(event) for event in events if short_words(event)]
    boxes = [one.get_window_extent() for one in (*panel.texts, *panel.patches)]
    inside = panel.get_window_extent()
    assert all(inside.x0 - 1 <= box.x0 and box.x1 <= inside.x1 + 1 for box in boxes)
    assert not any(one.overlaps(other) for one, other in combinations(boxes[: len(panel.texts)], 2))


def test_frames_of_the_tare_are_empty() -> None:
    figure, collected = drawn(pressed(3), Settings(tare=20, backend="reference"))
    columns = collected.columns("pad")
    assert np.isnan(columns.normal[:20]).all()
    assert np.isfinite(columns.normal[20:]).all()
    assert [text.get_text() for text in axis(figure, "normal [N]").get_legend().get_texts()] == ["tare"]


@pytest.mark.parametrize(("x", "beyond"), [(None, False), (1.0, True)])
def test_uncertain_loads_are_crosses_and_not_on_the_lines(x: float | None, beyond: bool) -> None:
    """The first 30 frames of a touch are uncertain, at their place or 1 m away."""
    source, collected, number = open_source(SCENES / "needle.toml"), Collected(), itertools.count()

    def doubt(report: FrameReport) -> None:
        if next(number) < 30:
            moved: dict[str, Any] = {"x": x, "F": 1e6} if x is not None else {}
            report = replace(report, load=replace(report.load, validity=Validity.AMBIGUOUS, **moved))
        collected(report)

    run(source, Settings(backend="reference"), [doubt])
    figure = picture(collected, source.arrays, "t")
    title = axis(figure, "y [mm]").get_title(loc="left")
    assert "crosses: uncertain, 30 frames" in title
    assert ("30 beyond the edge" in title) == beyond
    normal = axis(figure, "normal [N]")
    assert np.isnan(normal.lines[0].get_ydata()[:30]).all()
    assert normal.lines[1].get_ydata().size == 30
    assert ("30 of them beyond the axis" in normal.get_legend().get_texts()[0].get_text()) == beyond


def test_missing_readings_are_not_drawn_as_zero() -> None:
    """For a taxel without valid readings, and for recordings without any."""
    source = pressed(3, 1.0, 0.3)
    valid = np.ones((3, 3), bool)
    valid[0, 0] = False
    frames = [Frame(0, one.t, one.sequence, one.values, valid) for one in source]
    figure, _ = drawn(FrameStream("pad", source.arrays, None, len(frames), frames))
    plane = axis(figure, "y [mm]")
    assert "crosses: no reading, 1 taxel" in plane.get_title(loc="left")
    assert np.isnan(plane.images[0].get_array().filled(np.nan)[0, 0])
    assert quiver(plane).Umask.sum() == 1
    blind = [Frame(0, one.t, one.sequence, one.values, valid & False) for one in source]
    for given, words in ((blind, "no frame with a valid reading"), ([], "no frame")):
        figure, collected = drawn(FrameStream("pad", source.arrays, None, len(given), list(given)))
        assert collected.strongest == {}
        assert words in axis(figure, "y [mm]").get_title(loc="left")
        assert not axis(figure, "y [mm]").images
        assert [text.get_text() for text in axis(figure, "shear").get_legend().get_texts()] == [
            "x: not known",
            "y: not known",
        ]
    assert not axis(figure, "shear").get_xticks().size


def test_a_run_without_frames_is_drawn(tmp_path: Path) -> None:
    source = pressed(2, 0.0)
    collected = Collected()
    draw(collected, source.arrays, "a $title$ of nothing", tmp_path / "none.png")
    run(source, Settings(backend="reference"), [collected])
    draw(collected, source.arrays, "zeros", tmp_path / "zeros.png")
    assert (tmp_path / "none.png").stat().st_size > 5_000


@pytest.mark.parametrize(("rows", "cols", "names"), [(1, 3, ["x", "y: not known"]), (3, 1, ["x: not known", "y"])])
def test_the_unknown_shear_of_one_row_or_column_is_marked(
    tmp_path: Path, rows: int, cols: int, names: list[str]
) -> None:
    (tmp_path / "line.toml").write_text(
        "title = 'line'\nrate_hz = 50\nduration_s = 0.5\n[cover]\nyoungs_modulus_mpa = 2.4\nquantity = 'stress'\n"
        f"[[finger]]\nname = 'line'\nrows = {rows}\ncols = {cols}\npitch_mm = 1.5\ndepth_mm = 1.5\n"
        "[[load]]\nfinger = 'line'\npath = [[0, 0, 0, 0.1, 0.1, 0.3], [0.5, 0, 0, 0.1, 0.1, 0.5]]\n"
    )
    figure, _ = drawn(open_source(tmp_path / "line.toml"))
    legend = axis(figure, "shear").get_legend()
    assert [text.get_text() for text in legend.get_texts()] == names


def test_simultaneous_loads_are_drawn_and_recorded(tmp_path: Path) -> None:
    scene = tmp_path / "two.toml"
    loads = "".join(
        f'[[load]]\nfinger = "tip"\npath = [[0.1, {x}, 0, 0, 0, 0], [0.2, {x}, 0, 0, 0, 0.3], [0.4, {x}, 0, 0, 0, 0.3]]'
        "\n"
        for x in (-3, 3)
    )
    scene.write_text(
        'title = "two"\nrate_hz = 50\nduration_s = 0.6\n[cover]\nyoungs_modulus_mpa = 2.4\n[[finger]]\nname = "tip"\n'
        f"rows = 8\ncols = 8\npitch_mm = 1.0\ndepth_mm = 1.0\n{loads}",
        encoding="utf-8",
    )
    source = open_source(scene)
    figure, collected = drawn(source)
    plane = axis(figure, "y [mm]")
    (dots,) = (one for one in plane.collections if one.get_offsets().shape[0] > 8 and one.get_array() is not None)
    x = np.asarray(dots.get_offsets())[:, 0]
    assert {round(float(one)) for one in x} == {-3, 3}
    assert f"several at once in {len(collected.others('tip'))} frames" in plane.get_title(loc="left")
    with RunRecord(tmp_path / "out", source.arrays, {}) as record:
        run(source, Settings(backend="reference"), [record])
    rows = list(csv.DictReader((tmp_path / "out" / "frames.csv").read_text(encoding="utf-8").splitlines()))
    both = [row for row in rows if row["load_others"]]
    assert len(both) == len(collected.others("tip"))
    places = {round(1e3 * float(row["load_others"].lstrip("'").split()[0])) for row in both}
    assert places <= {-3, 3}
    assert all(0 < float(row["load_sigma_x_m"]) < 1e-4 for row in both)
