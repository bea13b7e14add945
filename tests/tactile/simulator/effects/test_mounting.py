"""How an array is mounted: places, turns, thicknesses and a curved surface, each against the field computed there."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium
from tactile.elastic.rough_contact import RoughContact
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.mounting.cover_error import CoverError
from tactile.simulator.effects.mounting.curved_fingertip import CurvedFingertip
from tactile.simulator.effects.mounting.misplacement import Misplacement
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tests.oracles.elastic.layer import layer_load

ARRAY = TaxelArray("a", 4, 3, 1e-3, 1e-3, (2e-3, -1e-3))
LOAD = np.array([2.4e-3, -0.7e-3, 0.02, -0.01, 0.1])
RUBBER = Medium(2.4e6)


def under(*effects: Any, contact: Any = None) -> Field:
    load = contact or MovingLoad(0, np.array([(0.0, *LOAD)]))
    scene = Scene("s", 10.0, 0.1, 2.4e6, (ARRAY,), (), (load,), effects)
    (field,) = scene.affected(scene.skin.fields(0, scene.skin.chunks(0)), "field", scene.effects, 0)
    return field


def test_wide_taxels_turn_with_their_array_under_a_cover_that_is_uneven() -> None:
    # a cover that is thicker by as much over each is one more depth, for which nothing is interpolated
    wide, turned = TaxelArea(8e-4), Misplacement(0.0, 0.0, 0.4, 0.0, 0.0)
    uneven = under(CoverError(1e-4, 0.0, 0.0), turned, wide)
    deeper = replace(uneven, taxels=replace(uneven.taxels, depth=1.1e-3, thicker=None))
    assert uneven.values == pytest.approx(deeper.values, rel=1e-9, abs=1e-12)


def test_a_shifted_array_feels_what_is_where_it_lies() -> None:
    felt = under(Misplacement(1e-4, -2e-4, 0.0, 0.0, 0.0)).values[0]
    wanted = point_load(np.add(ARRAY.positions(), (1e-4, -2e-4)), 1e-3, LOAD[None], RUBBER)
    assert np.abs(felt - wanted).max() < 1e-12 * np.abs(wanted).max()


def test_a_turned_array_is_a_turned_load() -> None:
    turn, centre = 0.3, np.array(ARRAY.origin)
    c, s = np.cos(turn), np.sin(turn)
    back = np.array([[c, s], [-s, c]])  # the world seen from the array
    turned = np.concatenate([centre + back @ (LOAD[:2] - centre), back @ LOAD[2:4], LOAD[4:]])
    for area in ((), (TaxelArea(4e-4),)):
        felt = under(Misplacement(0.0, 0.0, turn, 0.0, 0.0), *area).values[0]
        nominal = under(*area, contact=MovingLoad(0, np.array([(0.0, *turned)]))).values[0]
        assert np.abs(felt - nominal).max() < 1e-12 * np.abs(nominal).max()


@pytest.mark.parametrize("thickness", (np.inf, 1.3e-3))
def test_a_cover_that_is_uneven_is_as_thick_as_over_each_taxel(thickness: float) -> None:
    layer = [FiniteThickness(thickness)] if np.isfinite(thickness) else []
    cases: tuple[tuple[Any, Callable[[float, float], float]], ...] = (
        (CoverError(1e-4, 0.05, -0.02), lambda x, y: 1e-4 + 0.05 * x - 0.02 * y),
        (Misplacement(0.0, 0.0, 0.0, 0.05, 0.1), lambda x, y: 0.05 * x + 0.1 * y),
        (CurvedFingertip(0.01), lambda x, y: -(x**2 + y**2) / 0.02),
    )
    for effect, thicker in cases:
        felt = under(effect, *layer).values[0]
        for row, col in np.ndindex(ARRAY.shape):
            at = ARRAY.positions()[row, col]
            more = thicker(*(at - ARRAY.origin))
            if layer:
                wanted = layer_load(at, 1e-3 + more, LOAD[None], thickness + more, RUBBER)
            else:
                wanted = point_load(at, 1e-3 + more, LOAD[None], RUBBER)
            assert np.abs(felt[row, col] - wanted).max() < 2e-4 * np.abs(felt).max()
    with pytest.raises(InputError, match="mm thinner over taxels 1 mm deep; less than that wanted"):
        _ = under(CoverError(-2e-3, 0.0, 0.0)).values


def test_a_ball_on_a_dome_touches_like_a_smaller_one() -> None:
    ball = MovingContact(0, Indenter("sphere", 5e-3), np.array([(0.0, *LOAD)]))
    curved = under(CurvedFingertip(0.02), contact=ball)
    assert curved.loads.discs[0].radii[0, 0] == pytest.approx(np.cbrt(0.75 * 0.1 * 4e-3 / 3.2e6))
    pressed = replace(ball, given_depth=True, path=np.array([(0.0, 0, 0, 0, 0, 1e-4)]))
    force = under(CurvedFingertip(0.02), contact=pressed).loads.totals[0, 0, 4]
    assert force == pytest.approx(4 / 3 * 3.2e6 * np.sqrt(4e-3) * 1e-6)


@pytest.mark.parametrize("thickness", (np.inf, 3e-3))
def test_a_needle_and_a_height_map_on_a_dome_touch_as_what_lies_between_them(thickness: float) -> None:
    # the gap to the dome, pressed onto a flat cover cell by cell: r^2 / 2 radius more than to a plane
    radius, deep, layer = 2e-3, 1e-4, [FiniteThickness(thickness)] if np.isfinite(thickness) else []
    steps = (np.arange(65) - 32) * 4e-5
    square = steps**2 + steps[:, None] ** 2
    sphere = radius - np.sqrt(radius**2 - square)
    path = np.array([(0.0, 0, 0, 0, 0, deep)])
    needle = MovingContact(0, Indenter("needle", radius), path, None, True)
    mapped = HeightMap(0, sphere, 4e-5, path, None, True)
    flat = [under(*layer, contact=one).loads.totals[0, 0, 4] for one in (needle, mapped)]
    for dome in (0.02, 0.004):
        cells = RoughContact(sphere + square / (2 * dome), 4e-5, replace(RUBBER, thickness=thickness))
        wanted = float(cells.pressed(deep).sum()) * 4e-5**2
        found = [under(CurvedFingertip(dome), *layer, contact=one).loads.totals[0, 0, 4] for one in (needle, mapped)]
        assert found == pytest.approx([wanted] * 2, rel=0.012)
        assert min(flat) > 1.04 * wanted
    (said,) = Scene("s", 10.0, 0.1, 2.4e6, (ARRAY,), (), (mapped,), (CurvedFingertip(0.004),)).range_notes or ("",)
    assert said == ""
    assert mapped.on_dome(0.0) is mapped


def test_flat_ends_and_lying_cylinders_from_which_a_dome_falls_away_are_told_of() -> None:
    end = MovingContact(0, Indenter("flat_punch", 1e-3), np.array([(0.0, 0, 0, 0, 0, 0.3)]))
    lying = MovingContact(0, Indenter("cylinder", 2e-3, 4e-3), np.array([(0.0, 0, 0, 0, 0, 0.3)]))

    def said(body: MovingContact, *effects: Any) -> str:
        return "\n".join(Scene("s", 10.0, 0.1, 2.4e6, (ARRAY,), (), (body,), effects).range_notes)

    # F = 2 E* a delta: 0.0469 mm deep, and the dome falls by a^2 / 2 radius under the rim
    share = 1e-6 / (2 * 0.05) / (0.3 / (2 * 3.2e6 * 1e-3))
    told = said(end, CurvedFingertip(0.05))
    assert f"a flat_punch: the curved cover falls away by 0.01 mm under its rim, {share:.2g} of its indentation" in told
    assert "the curved cover falls away by 0.04 mm under its ends" in said(lying, CurvedFingertip(0.05))
    for body in (end, lying):
        assert said(body) == said(body, CurvedFingertip(1.0)) == ""
