"""Loads that are not sure, in the picture of a touch."""

import numpy as np

from tactile.inverse.validity import Validity
from tactile.output.plot import picture
from tactile.sources import open_source
from tests.kits.paths import SCENES
from tests.tactile.output.test_plot import axis, drawn


def test_doubted_loads_beyond_the_axes_are_counted() -> None:
    source = open_source(SCENES / "needle.toml")
    _, collected = drawn(source)
    far = [
        (*row[:4], 1.0, 1.0, 0.0, 0.0, 1e6, float(Validity.AMBIGUOUS), *row[10:]) if n < 7 else row
        for n, row in enumerate(collected._rows["chip"])
    ]
    collected._rows["chip"] = far
    figure = picture(collected, source.arrays, "t")
    assert "crosses: uncertain, 7 frames, 7 beyond the edge" in axis(figure, "y [mm]").get_title(loc="left")
    (words,) = axis(figure, "normal").get_legend().get_texts()
    assert words.get_text().endswith("; 7 of them beyond the axis")


def test_doubted_loads_that_go_on_from_sure_ones_are_in_the_picture() -> None:
    """A tip that gets too wide for a point as it is pressed harder: the rest of the touch is not cut off."""
    source = open_source(SCENES / "needle.toml")
    _, collected = drawn(source)
    rows = collected._rows["chip"]
    force = np.linspace(0.1, 1.0, len(rows))
    worth = np.where(force > 0.6, Validity.NOT_ONE, Validity.INSIDE).astype(float)
    told = [(0.0, 0.0, 0.0, 0.0, *both) for both in zip(force, worth, strict=True)]
    collected._rows["chip"] = [(*row[:4], *load, *row[10:]) for row, load in zip(rows, told, strict=True)]
    figure = picture(collected, source.arrays, "t")
    assert axis(figure, "normal").get_ylim()[1] > 1
    (words,) = axis(figure, "normal").get_legend().get_texts()
    assert "beyond" not in words.get_text()
