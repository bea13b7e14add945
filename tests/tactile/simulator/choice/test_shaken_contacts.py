"""Contacts that tremble over a cover: how much depends on how stiff they are, and so on what the cover is."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.simulator.choice.auto_effects import all_effects, choose
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.field_bounds import FieldBounds
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.effects.adhesion import Adhesion
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.scene.scene import Scene
from tests.kits.touch.random_scenes import error, error_of_seeds, everything, needle

TREMBLES = ("needle_vibration", NeedleVibration(0.0, 1e-6))
LAYER = ("finite_thickness", FiniteThickness(1.2e-3))


def under_a_disc(*effects: Any, shape: Any = "disc", frames: int = 100, force: float = 0.02) -> Scene:
    path = [(0.0, 0, 0, 0, 0, force / 2), (1.0, 1e-4, 0, 0, 0, force)]
    disc = MovingContact(0, Indenter(shape, 3e-4), path)
    return replace(needle(*effects), loads=(), contacts=(disc,), rate=float(frames))


@pytest.mark.parametrize("reused", (False, True))
@pytest.mark.parametrize(
    ("thickness", "height", "tolerance"), ((8e-4, 1e-6, 0.2), (2e-3, 1e-6, 0.05), (4e-3, 1e-6, 0.02), (4e-4, 3e-7, 0.2))
)
def test_what_makes_a_trembling_contact_stiffer_counts_with_that(
    thickness: float, height: float, tolerance: float, reused: bool
) -> None:
    # on the layer of 4 mm 0.3 % of the peak at rest, and 3 % where the disc trembles
    layer, trembles = FiniteThickness(thickness), NeedleVibration(0.0, height)
    scene = under_a_disc(("needle_vibration", trembles), ("finite_thickness", layer))
    choice = choose(scene, tolerance, reused)
    assert error_of_seeds(choice.scene, everything(scene), range(3)) <= tolerance


def test_a_layer_that_does_little_at_rest_is_tried_under_what_trembles() -> None:
    calm, trembling = (
        EffectBounds(scene, all_effects(scene), tolerance=0.05, reused=True).sizes()["finite_thickness"]
        for scene in (under_a_disc(LAYER), under_a_disc(TREMBLES, LAYER))
    )
    assert trembling > 2 * calm


@pytest.mark.parametrize("tolerance", (0.0, 0.5))
def test_tremors_of_a_point_are_bounded_on_the_layer_as_it_is(tolerance: float) -> None:
    # held by a wide tip over a thin cover it is three times as stiff as on the half-space
    shakes = ("needle_vibration", NeedleVibration(0.0, 1e-7, 2e-3))
    scene = needle(("finite_thickness", FiniteThickness(2.2e-4)), shakes)
    bounds = EffectBounds(scene, scene.effects, tolerance=tolerance)
    sizes = bounds.sizes()
    still, thick = (
        scene.with_effects([one for one in scene.effects if one[0] != gone]) for gone in (shakes[0], LAYER[0])
    )
    seen = error_of_seeds(still, scene, range(6))
    assert 2 * error_of_seeds(scene.with_effects([]), thick, range(6)) < seen <= sizes["needle_vibration"]
    assert error_of_seeds(thick, scene, range(6)) <= sizes["finite_thickness"]


@pytest.mark.parametrize("wavy", (False, True))
@pytest.mark.parametrize("shape", ("disc", "flat_punch", "sphere"))
def test_tremors_are_bounded_on_the_layer_as_it_is(shape: Any, wavy: bool) -> None:
    thin = ("finite_thickness", FiniteThickness(2.2e-4))
    shakes = (
        ("surface_waviness", SurfaceWaviness(5e-7, 3e-4)) if wavy else ("needle_vibration", NeedleVibration(0, 2e-7))
    )
    scene = under_a_disc(thin, shakes, shape=shape, force=0.01)
    size = EffectBounds(scene, scene.effects).sizes()[shakes[0]]
    still = scene.with_effects([one for one in scene.effects if one[0] != shakes[0]])
    assert all(error(replace(still, seed=seed), replace(scene, seed=seed)) <= size for seed in range(10))


def test_what_fixed_effects_change_grows_with_the_tremor() -> None:
    # by slopes alone, in one run of few frames
    area = ("taxel_area", TaxelArea(4e-5))
    calm, trembling = (
        EffectBounds(scene, all_effects(scene), tolerance=0.02).sizes()["taxel_area"]
        for scene in (needle(area), needle(area, ("needle_vibration", NeedleVibration(0.0, 2e-6))))
    )
    assert trembling > 1.2 * calm


def test_effects_that_save_nothing_are_weighed_in_a_long_recording() -> None:
    scene = under_a_disc(("poisson_ratio", PoissonRatio(0.49)), shape="flat_punch", frames=2500)
    scene = replace(scene, arrays=(TaxelArray("pad", 5, 5, 4e-4, 2e-4),))
    assert error(choose(scene, 0.1).scene, everything(scene)) <= 0.1


def test_a_contact_that_a_rare_tremor_presses_through_the_cover_is_no_error() -> None:
    deep = MovingContact(0, Indenter("sphere", 5e-4), np.array([(0.0, 0, 0, 0, 0, 1.6e-4)]), None, True)
    wild = ("needle_vibration", NeedleVibration(0.0, 1e-5))
    scene = replace(needle(("finite_thickness", FiniteThickness(2.1e-4)), wild), loads=(), contacts=(deep,))
    scene = replace(scene, rate=20.0)
    for reused in (False, True):
        assert choose(scene, 0.02, reused).bound <= 0.02


def test_what_does_not_stick_is_not_tried_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def tried(*_given: Any) -> Any:
        raise AssertionError

    scene = replace(needle(("adhesion", Adhesion(0.05))), rate=3000.0)
    monkeypatch.setattr(FieldBounds, "_try", tried)
    choice = choose(scene, 0.05, reused=True)
    assert "adhesion" in choice.off
    assert choice.sizes["adhesion"] == 0
