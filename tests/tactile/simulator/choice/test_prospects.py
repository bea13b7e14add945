"""Whether choosing effects pays in one run: told by sizes alone, before anything is computed."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.core.loads import F
from tactile.elastic.medium import Medium
from tactile.simulator.choice.auto_effects import all_effects, candidates, choose
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.forces import highest_reading, sinks_in, unseen
from tactile.simulator.choice.prospects import may_pay, points_may_pay
from tactile.simulator.contacts.adhesion_path import adhesion_table as table
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.effects import effect_class, without
from tactile.simulator.effects.adhesion import Adhesion
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.mounting.curved_fingertip import CurvedFingertip
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tests.kits.touch.random_scenes import error, everything, needle


def under_a_ball(*effects: Any, frames: int = 200, depth: bool = False) -> Scene:
    push = 3e-5 if depth else 0.02
    path = [(0.0, 0, 0, 0, 0, push / 2), (1.0, 1e-4, 0, 0, 0, push)]
    ball = MovingContact(0, Indenter("sphere", 5e-4), path, given_depth=depth)
    return replace(needle(*effects), loads=(), contacts=(ball,), rate=float(frames))


def test_where_little_can_be_saved_nothing_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    computed = [0]

    def counted(_field: Field) -> Any:
        computed[0] += 1
        raise AssertionError

    with monkeypatch.context() as patch:
        for what in ("values", "loads"):
            patch.setattr(vars(Field)[what], "func", counted)
        choice = choose(under_a_ball().with_effects(()), 0.02)
    assert not choice.tried
    assert choice.off == frozenset()
    assert choice.bound == 0
    assert computed[0] == 0


@pytest.mark.parametrize("force", np.geomspace(1e-6, 100, 5))
@pytest.mark.parametrize("shape", ("needle", "sphere", "flat_punch"))
def test_how_deep_a_body_sinks_in_is_bounded(shape: Any, force: float) -> None:
    body, medium = Indenter(shape, 2e-4), Medium(2.4e6)
    contact = MovingContact(0, body, [(0.0, 0, 0, 0, 0, force)])
    deep = float(body.indentation(np.array([force]), medium)[0])
    assert (1 - 1e-12) * deep <= sinks_in(contact, medium, 1e-3) <= 1.3 * deep


@pytest.mark.parametrize("by_depth", (True, False))
@pytest.mark.parametrize("work", (1e-3, 0.05, 1.0))
@pytest.mark.parametrize("shape", ("needle", "sphere", "flat_punch"))
def test_how_deep_what_sticks_sinks_in_is_bounded(shape: Any, work: float, by_depth: bool) -> None:
    body = Indenter(shape, 2e-4)
    for push, (nu, thickness) in product(
        (0.0, 4e-5) if by_depth else (0.0, 1e-4, 0.01), ((0.5, np.inf), (0.5, 3e-4), (0.3, 1e-3), (0.0, 1e-2))
    ):
        medium = Medium(2.4e6, nu)
        contact = MovingContact(0, body, [(0.0, 0, 0, 0, 0, push)], None, by_depth)
        bound = sinks_in(contact, medium, 1e-3, Rig(work=work))
        if bound < 0.9 * thickness:
            law = table(body.round, replace(medium, thickness=thickness), work, contact.path[:, [0, 1 + F]], by_depth)
            assert law.indentation[-1] <= bound * (1 + 1e-9)


def test_how_deep_what_sticks_goes_is_known_without_its_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def computed(*_given: Any) -> Any:
        raise AssertionError

    scene = under_a_ball(depth=True).with_effects((("adhesion", Adhesion(0.05)),))
    monkeypatch.setattr(Scene, "loads_at", computed)
    assert not choose(scene, 0.02).tried


def test_a_typical_cover_in_which_a_needle_would_be_as_wide_as_itself_has_no_meaning() -> None:
    deep = MovingContact(0, Indenter("needle", 5e-5), [(0.0, 0, 0, 0, 0, 0), (1.0, 0, 0, 0, 0, 1.5e-3)], None, True)
    scene = replace(needle(), arrays=(TaxelArray("pad", 2, 2, 1e-3, 3e-3),), loads=(), contacts=(deep,), effects=())
    named = [name for name, _ in candidates(scene)]
    assert "finite_thickness" not in named
    assert "poisson_ratio" in named


def test_effects_behind_the_field_are_not_asked_where_they_cannot_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    def asked(*_given: Any) -> float:
        raise AssertionError

    scene = needle().with_effects(
        (("quantisation", without(effect_class("quantisation"))),)
    )  # steps would decide alone
    effects = all_effects(scene)
    for _, effect in effects:
        if hasattr(effect, "reach"):
            monkeypatch.setattr(type(effect), "reach", asked)
    assert not may_pay(scene, effects, 0.02)
    long = replace(scene, rate=1e4, arrays=(TaxelArray("pad", 8, 8, 4e-4, 2e-4),))
    with pytest.raises(AssertionError):
        may_pay(long, effects, 1e-6)


def test_a_dear_effect_that_is_small_is_left_out_where_bodies_press_for_few_frames() -> None:
    pad = (TaxelArray("pad", 8, 8, 4e-4, 2e-4),)
    scene = replace(under_a_ball(), arrays=pad).with_effects((("taxel_area", TaxelArea(4e-6)),))
    choice = choose(scene, 0.02)
    assert choice.tried
    assert "taxel_area" in choice.off
    assert error(choice.scene, everything(scene)) <= 0.02
    assert may_pay(scene, all_effects(scene), 0.02)
    wide = scene.with_effects((("taxel_area", TaxelArea(3e-4)),))
    assert not may_pay(wide, all_effects(wide), 0.02)


@pytest.mark.parametrize("law", [("finite_thickness", FiniteThickness(2.2e-4)), ("adhesion", Adhesion(0.5))])
def test_slopes_of_the_ideal_skin_bound_nothing_where_a_body_presses_otherwise(law: tuple[str, Any]) -> None:
    # by depth a layer takes several times the force
    scene = under_a_ball(("taxel_area", TaxelArea(4e-5)), law, depth=law[0] == "finite_thickness")
    bounds = EffectBounds(scene, all_effects(scene), tolerance=0.02)
    assert bounds.sizes()["taxel_area"] == np.inf
    alone = under_a_ball(("taxel_area", TaxelArea(4e-5)))
    assert EffectBounds(alone, all_effects(alone), tolerance=0.02).sizes()["taxel_area"] < 0.2


def test_effects_without_strength_are_no_part_of_what_is_tried_together() -> None:
    some = ("finite_thickness", FiniteThickness(4e-3)), ("poisson_ratio", PoissonRatio(0.4999))
    scene = under_a_ball(*some, ("finite_tip", FiniteTip(2e-6)), ("curved_fingertip", CurvedFingertip(50.0)))
    choice = choose(scene, 0.1, reused=True)
    assert {"finite_thickness", "poisson_ratio"} <= choice.off
    assert error(choice.scene, everything(scene)) <= 0.1


def test_where_steps_are_likely_coarse_nothing_is_chosen() -> None:
    # loads that pass between taxels read half of what they would over one: half a step is then half of the tolerance
    scene = needle(
        ("quantisation", Quantisation(6, 1.5)), ("finite_tip", FiniteTip(1e-6)), ("taxel_area", TaxelArea(1e-6))
    )
    step, highest = Quantisation(6, 1.5).grain(unseen(scene, 0, 1.0)), highest_reading(scene)
    long = replace(scene, rate=1e4)
    for share, pays in ((2.0, True), (1.0, False)):
        tolerance = share * step / highest
        bounds = EffectBounds(long, all_effects(long), tolerance=tolerance)
        assert points_may_pay(long, bounds, tolerance) == pays


def test_where_effects_take_little_points_are_not_judged() -> None:
    # a dear effect that is small is left out of few frames; cheap ones, as small, are left on: the field alone, which
    # tells their bounds, takes longer than they do
    few = {"poisson_ratio": PoissonRatio(0.4999), "quantisation": Quantisation(16, 1.5)}
    dear = {"taxel_area": TaxelArea(3e-6), "finite_tip": FiniteTip(2e-6), "surface_waviness": SurfaceWaviness(1e-10)}
    for effects, frames, off in ((few, 200, set()), (few | dear, 200, dear.keys()), (few, 100_000, set())):
        scene = replace(needle(*effects.items()), rate=float(frames))
        choice = choose(scene, 0.02)
        assert choice.tried == bool(off)
        assert off <= choice.off
        assert error(choice.scene, everything(scene)) <= choice.bound <= 0.02


def test_typical_effects_are_judged_where_the_tolerance_has_room_for_some() -> None:
    for tolerance, frames, pays in ((0.02, 200, False), (0.3, 200, True), (0.02, 2_000, True)):
        scene = replace(needle().with_effects(()), rate=float(frames))
        bounds = EffectBounds(scene, all_effects(scene), tolerance=tolerance)
        assert points_may_pay(scene, bounds, tolerance) == pays


def test_a_tip_on_a_layer_saves_nothing() -> None:
    tip, layer = ("finite_tip", FiniteTip(2e-6)), ("finite_thickness", FiniteThickness(8e-4))
    for effects, pays in (((tip,), True), ((tip, layer), False)):
        scene = replace(needle(*effects), rate=2000.0, arrays=(TaxelArray("pad", 8, 8, 4e-4, 2e-4),))
        assert may_pay(scene, all_effects(scene), 0.02) == pays
