"""Single loads on a cover hardly thicker than the taxels lie deep, which nobody knows: wrong places are in doubt."""

import numpy as np
import pytest

from tactile import Load, Settings, TaxelArray, run
from tactile.core.frame import Frame
from tactile.core.source import FrameStream
from tactile.elastic.layer_loads import layered_load
from tactile.elastic.medium import Felt, Medium
from tactile.inverse.validity import Validity

DEPTH = 1e-3
GROSS = 0.3
"""[depths]"""


def located(side: int, quantity: Felt, pitch: float, thickness: float, load: tuple[float, ...]) -> tuple[Load, float]:
    """Return what the pipeline locates of (x, y) [depths] and (Q, R, F) [N], and how far off in depths."""
    pad, (x, y, *forces) = TaxelArray("pad", side, side, pitch * DEPTH, DEPTH, quantity=quantity), load
    cover, loads = Medium(2.4e6, quantity=quantity, thickness=thickness * DEPTH), []
    values = layered_load(pad.positions(), DEPTH, [[x * DEPTH, y * DEPTH, *forces]], cover)
    stream = FrameStream("cover", (pad,), 2.4e6, 1, [Frame(0, 0.0, 0, values, np.ones(pad.shape, bool))])
    run(stream, Settings(tare="off"), [lambda report: loads.append(report.load)])
    return loads[0], float(np.hypot(loads[0].x / DEPTH - x, loads[0].y / DEPTH - y))


@pytest.mark.parametrize(
    ("side", "quantity", "thickness", "load"),
    [
        (2, "strain", 1.02, (-0.978, 0.987, 0.166, 0.118, 0.387)),
        (2, "strain", 1.1, (-0.403, 1.319, -0.001, -0.002, 0.133)),
        (4, "strain", 1.02, (2.773, 1.826, 0.018, 0.063, 0.375)),
        (4, "stress", 1.5, (-0.868, 0.152, 0.175, 0.067, 0.334)),
    ],
)
def test_a_wrong_place_is_said_to_be_in_doubt(
    side: int, quantity: Felt, thickness: float, load: tuple[float, ...]
) -> None:
    answer, off = located(side, quantity, 1.5, thickness, load)
    assert off > GROSS
    assert answer.misfit < 0.25  # of that alone it would pass for a wide tip
    assert answer.validity is Validity.AMBIGUOUS


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_a_right_place_on_a_thicker_cover_is_inside(quantity: Felt) -> None:
    for x, y in ((0.1, 0.2), (-0.4, 0.3)):
        answer, off = located(4, quantity, 1.0, 2.0, (x, y, 0.03, -0.05, 0.3))
        assert off < GROSS / 3
        assert answer.validity is Validity.INSIDE
