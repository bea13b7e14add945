"""Loads on covers of known and unknown thickness: places, forces and deviations, against the layer's integrals."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim.support import Flags, Floats
from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.settings import Settings
from tests.kits.touch.pads import SCALE, as_row
from tests.oracles.elastic.layer import layer_load, layered_load
from tests.oracles.elastic.localise import bound

DEPTH, MODULUS = 1e-3, 2.4e6
GROSS = 0.3
"""[depths]"""


class Cover:
    """A pad under a cover of a given thickness [depths], its signals under loads, and the located loads."""

    def __init__(self, shape: tuple[int, int], quantity: Quantity, pitch: float, thickness: float) -> None:
        self.medium = Medium(MODULUS, quantity="stress" if quantity == "stress" else "strain")
        self.thickness = thickness * DEPTH
        self.array = TaxelArray("pad", *shape, pitch * DEPTH, DEPTH, quantity=quantity, thickness=self.thickness)
        self._finger = Finger(self.array, MODULUS, Settings(tare="off"))

    def measured(self, loads: Floats) -> Floats:
        return layer_load(self.array.positions(), DEPTH, loads, self.thickness, self.medium)

    def found(self, values: Floats, valid: Flags | None = None) -> Load:
        there = np.ones(self.array.shape, bool) if valid is None else valid
        return self._finger.locate(Frame(0, 0.0, 0, values, there))


def draw(random: np.random.Generator, shape: tuple[int, int], pitch: float) -> Floats:
    x, y = random.uniform(-1, 1, 2) * [shape[1] * pitch * DEPTH / 2, shape[0] * pitch * DEPTH / 2]
    force, part, turn = random.uniform(0.1, 0.5), random.uniform(0, 0.6), random.uniform(0, 2 * np.pi)
    return np.array([x, y, part * force * np.cos(turn), part * force * np.sin(turn), force])


@pytest.mark.parametrize("quantity", ["strain", "stress"])
@pytest.mark.parametrize("thickness", [1.0, 1.5])
def test_place_and_forces_are_those_on_the_layer(quantity: Quantity, thickness: float) -> None:
    random, off, force = np.random.default_rng(4), [], []
    for shape, pitch in (((2, 2), 0.75), ((4, 4), 1.5), ((8, 8), 1.0), ((3, 5), 1.0)):
        cover = Cover(shape, quantity, pitch, thickness)
        for _ in range(6):
            wanted = draw(random, shape, pitch)
            clean = cover.measured(wanted[None])
            exact = cover.found(clean)
            assert as_row(exact) == pytest.approx(wanted, abs=2e-5 * max(DEPTH, abs(wanted[4])))
            assert (exact.validity, exact.others, exact.misfit < 1e-4) == (Validity.INSIDE, (), True)
            load = cover.found(clean + random.normal(size=clean.shape) * 1e-3 * np.abs(clean).max())
            assert load.validity is Validity.INSIDE
            off.append(np.hypot(load.x - wanted[0], load.y - wanted[1]) / DEPTH)
            force.append(abs(load.F / wanted[4] - 1))
    assert np.median(force) < 0.01
    assert max(off) < 0.1


def test_an_unknown_thickness_increases_the_misfit() -> None:
    cover = Cover((4, 4), "stress", 1.0, 1.02)
    wanted = np.array([0.3 * DEPTH, -0.2 * DEPTH, 0.05, 0.02, 0.3])
    values = cover.measured(wanted[None])
    known = cover.found(values)
    unknown = Finger(replace(cover.array, thickness=None), MODULUS, Settings(tare="off"))
    guessed = unknown.locate(Frame(0, 0.0, 0, values, np.ones((4, 4), bool)))
    assert as_row(known) == pytest.approx(wanted, abs=1e-5)
    assert guessed.F > 1.25 * 0.3
    assert guessed.misfit > 0.05 > 1e3 * known.misfit


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_errors_agree_with_the_deviations(quantity: Quantity) -> None:
    random, cover = np.random.default_rng(8), Cover((4, 4), quantity, 1.0, 1.25)
    wanted = np.array([0.4 * DEPTH, -0.7 * DEPTH, 0.04, -0.06, 0.3])
    clean = cover.measured(wanted[None])
    noise = 3e-3 * float(np.abs(clean).max())
    least = bound(lambda loads: cover.measured(np.atleast_2d(loads)), wanted, noise, SCALE)
    loads = [cover.found(clean + random.normal(size=clean.shape) * noise) for _ in range(100)]
    errors = np.array([as_row(load) for load in loads]) - wanted
    assert (np.sqrt((errors**2).mean(axis=0)) < 1.3 * least).all()
    assert np.array([load.sigma for load in loads]).mean(axis=0) == pytest.approx(least, rel=0.1)


def test_two_loads_and_a_stuck_taxel_are_found_on_a_thin_cover() -> None:
    cover = Cover((8, 8), "stress", 1.0, 1.1)
    loads = np.array([[-2e-3, -1e-3, 0.02, 0.0, 0.3], [2e-3, 1.5e-3, 0.0, -0.03, 0.2]])
    found = cover.found(cover.measured(loads))
    assert len(found.others) == 1
    for load, wanted in zip((found, *found.others), loads, strict=True):
        assert as_row(load) == pytest.approx(wanted, abs=1e-5)
    values = cover.measured(loads[:1])
    values[2, 4] = np.abs(values).max()
    found = cover.found(values)
    assert (found.left_out, found.others) == (((2, 4),), ())
    assert as_row(found) == pytest.approx(loads[0], abs=1e-5)


def test_shear_across_a_line_is_determined_on_a_thin_cover_only() -> None:
    wanted = np.array([0.3e-3, 0.4e-3, 0.05, -0.08, 0.3])
    thin, thick = (Cover((1, 6), "strain", 1.0, h) for h in (1.3, 50.0))
    assert as_row(thin.found(thin.measured(wanted[None]))) == pytest.approx(wanted, abs=1e-4)
    assert np.isnan(thick.found(thick.measured(wanted[None])).R)


def test_one_taxel_on_a_thin_cover_is_ambiguous() -> None:
    """Its three readings fit several loads with different shear and places."""
    for thickness, wanted in ((1.2, Validity.AMBIGUOUS), (30.0, Validity.INSIDE)):
        cover = Cover((1, 1), "stress", 1.0, thickness)
        assert cover.found(cover.measured(np.array([[0.6e-3, 0.3e-3, 0.0, 0.0, 0.3]]))).validity is wanted


@pytest.mark.parametrize(
    ("load", "unread"),
    [
        ((0.53563444, 0.22912112, 0.12779368, -0.02165908, 0.65726242), (0, 1)),  # a local minimum far away
        ((-0.67812402, 0.67157131, 0.16436352, 0.05940185, 0.53632986), (1, 1)),
        ((0.60115933, 0.74412281, -0.05589415, 0.18798424, 0.43480683), (1, 0)),  # (-1.55, 0.42) fits too
    ],
)
def test_three_taxels_on_the_bottom_locate_the_load_or_are_ambiguous(
    load: tuple[float, ...], unread: tuple[int, int]
) -> None:
    cover = Cover((2, 2), "strain", 1.5, 1.0)
    wanted = np.array(load) * [DEPTH, DEPTH, 1, 1, 1]
    values, valid = cover.measured(wanted[None]).reshape(2, 2, 3).copy(), np.ones((2, 2), bool)
    values[unread], valid[unread] = np.nan, False
    found = cover.found(values, valid)
    off = float(np.hypot(found.x - wanted[0], found.y - wanted[1])) / DEPTH
    assert off < 0.01 or found.validity is Validity.AMBIGUOUS


def located(
    side: int, quantity: FieldQuantity, pitch: float, thickness: float, load: tuple[float, ...]
) -> tuple[Load, float]:
    """Return the load located from (x, y) [depths] and (Q, R, F) [N] without the thickness, and its error [depths]."""
    pad, (x, y, *forces) = TaxelArray("pad", side, side, pitch * DEPTH, DEPTH, quantity=quantity), load
    cover = Medium(MODULUS, quantity=quantity, thickness=thickness * DEPTH)
    values = layered_load(pad.positions(), DEPTH, [[x * DEPTH, y * DEPTH, *forces]], cover)
    answer = Finger(pad, MODULUS, Settings(tare="off")).locate(Frame(0, 0.0, 0, values, np.ones(pad.shape, bool)))
    return answer, float(np.hypot(answer.x / DEPTH - x, answer.y / DEPTH - y))


@pytest.mark.parametrize(
    ("side", "quantity", "thickness", "load"),
    [
        (2, "strain", 1.02, (-0.978, 0.987, 0.166, 0.118, 0.387)),
        (2, "strain", 1.1, (-0.403, 1.319, -0.001, -0.002, 0.133)),
        (4, "strain", 1.02, (2.703, -2.135, 0.179, -0.075, 0.254)),
        (4, "stress", 1.5, (-2.561, -1.453, 0.105, 0.079, 0.177)),
    ],
)
def test_a_wrong_place_on_an_unknown_thin_cover_is_ambiguous(
    side: int, quantity: FieldQuantity, thickness: float, load: tuple[float, ...]
) -> None:
    answer, off = located(side, quantity, 1.5, thickness, load)
    assert off > GROSS
    assert answer.misfit < 0.25  # like that of a wide tip
    assert answer.validity is Validity.AMBIGUOUS


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_a_right_place_on_a_thicker_cover_is_inside(quantity: FieldQuantity) -> None:
    for x, y in ((0.1, 0.2), (-0.4, 0.3)):
        answer, off = located(4, quantity, 1.0, 2.0, (x, y, 0.03, -0.05, 0.3))
        assert off < GROSS / 3
        assert answer.validity is Validity.INSIDE
