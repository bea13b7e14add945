"""Contacts held so lightly that what shakes them multiplies their forces, or that pull: bounds are found there, too."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tactile.simulator.choice.auto_effects import all_effects, choose
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.extremes import extremes
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.adhesion import Adhesion
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.mounting.misplacement import Misplacement
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.held_needle import grown, pressed_by, raised
from tactile.simulator.scene.scene import Scene
from tests.kits.touch.random_scenes import error, error_of_seeds, everything, needle

LIGHT = 27e-6
"""A force [N] under which a ball of 0.5 mm sinks in by half a micrometre."""
TREMBLES = ("needle_vibration", NeedleVibration(0.0, 1e-6))


def under(*effects: Any, path: Any, shape: Any = "sphere", frames: int = 300) -> Scene:
    body = MovingContact(0, Indenter(shape, 5e-4), path)
    return replace(needle(*effects), loads=(), contacts=(body,), rate=float(frames))


def touched_once(shear: float) -> list[tuple[float, ...]]:
    """Pressed hard without shear for a moment, then dragged along lightly until it is let go."""
    return [
        (0.0, 0, 0, 0, 0, 0.02), (0.2, 1e-4, 0, 0, 0, 0.02), (0.3, 1e-4, 0, 0, 0, LIGHT),
        (0.52, 1e-4, 0, 0, 0, LIGHT), (0.6, 1e-4, 0, shear, 0, LIGHT), (0.62, 1e-4, 0, shear, 0, LIGHT),
        (0.7, 1e-4, 0, 0, 0, LIGHT),
        (1.0, 1e-4, 0, 0, 0, 0.01),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("shape", "shear", "height", "tolerance", "other"),
    (
        ("needle", 2.1e-3, 3.1e-7, 0.18, ("poisson_ratio", PoissonRatio(0.498))),
        ("flat_punch", 4.8e-4, 3.5e-8, 0.14, ("finite_thickness", FiniteThickness(9.4e-3))),
        ("sphere", 2.0e-3, 1.3e-7, 0.05, ("misplacement", Misplacement(1.5e-7, 0.0, 0.0, 0.0, 0.0))),
        ("sphere", 3e-5, 1e-6, 0.03, ("adhesion", Adhesion(1e-4))),
        ("sphere", 1e-3, 1e-6, 0.03, ("adhesion", Adhesion(1e-4))),
    ),
)
def test_what_is_small_at_the_peak_is_tried_where_contacts_are_light(
    shape: Any, shear: float, height: float, tolerance: float, other: Any
) -> None:
    trembles = ("needle_vibration", NeedleVibration(0.0, height))
    scene = under(trembles, other, path=touched_once(shear), shape=shape)
    choice = choose(scene, tolerance, reused=True)
    assert error_of_seeds(choice.scene, everything(scene), range(3)) <= min(choice.bound + 1e-9, tolerance)


def test_frames_of_light_contacts_are_among_those_that_tell() -> None:
    scene = under(TREMBLES, path=touched_once(1e-4))
    found = extremes(scene, 0, [(5e-6, 5e-5)])
    light = (found.times >= 0.5) & (found.times <= 0.62)
    assert light.any()
    calm = extremes(scene, 0).times
    assert not ((calm > 0.5) & (calm < 0.62)).any()
    pieces = extremes(replace(scene, rate=3000.0), 0, [(5e-6, 5e-5)])
    assert pieces.whole is None
    assert pieces.growth == pytest.approx(found.growth, rel=0.01)


@pytest.mark.parametrize("shape", ("sphere", "needle", "flat_punch"))
def test_a_pull_that_only_what_sticks_can_hold_counts(shape: Any) -> None:
    pulled = [(0.0, 0, 0, 0, 0, 1e-2), (0.5, 0, 0, 0, 0, 5e-3), (0.55, 0, 0, 0, 0, -5e-4), (0.6, 0, 0, 0, 0, 5e-3),
              (1.0, 0, 0, 0, 0, 1e-2)]  # fmt: skip
    scene = under(("adhesion", Adhesion(0.35)), path=pulled, shape=shape)
    whole, bare = everything(scene), scene.with_effects([one for one in scene.effects if one[0] != "adhesion"])
    size = EffectBounds(scene, all_effects(scene), tolerance=0.02, reused=True).sizes()["adhesion"]
    assert 0.04 < error(bare, whole) <= size


@pytest.mark.parametrize("point", (False, True))
def test_random_effects_are_bounded_where_others_of_them_raise_contacts(point: bool) -> None:
    # hills of a nanometre do more under a ball that trembles by 1 um than under one at rest
    ball, force = 1e-3, LIGHT / 10
    path = np.array([(0.0, 0, 0, force, 0, force), (1.0, 1e-4, 0, force, 0, force)])
    trembles = ("needle_vibration", NeedleVibration(0.0, 1e-6, ball))
    wavy = ("surface_waviness", SurfaceWaviness(1e-9, 1e-3, ball))
    loads = (MovingLoad(0, path),) if point else ()
    contacts = () if point else (MovingContact(0, Indenter("sphere", ball), path),)
    calm, shaken = (replace(needle(*some), loads=loads, contacts=contacts) for some in ((wavy,), (wavy, trembles)))
    alone, beside = (
        EffectBounds(one, all_effects(one), tolerance=0.02, reused=True).sizes()["surface_waviness"]
        for one in (calm, shaken)
    )
    still = shaken.with_effects([one for one in shaken.effects if one[0] != "surface_waviness"])
    assert alone < error_of_seeds(still, shaken, range(6)) <= beside


def test_a_tip_is_wider_under_what_presses_it_harder() -> None:
    path = np.array([(0.0, 0, 0, 1e-7, 0, 1e-7), (1.0, 1e-4, 0, 1e-7, 0, 1e-7)])
    scene = replace(needle(TREMBLES, ("finite_tip", FiniteTip(2e-4))), loads=(MovingLoad(0, path),))
    bare = scene.with_effects([one for one in scene.effects if one[0] != "finite_tip"])
    size = EffectBounds(scene, all_effects(scene), tolerance=0.02).sizes()["finite_tip"]
    assert error_of_seeds(bare, scene, range(6)) <= size


@pytest.mark.parametrize("point", (False, True))
def test_what_a_rise_adds_to_readings_and_forces(point: bool) -> None:
    # a ball sinks in by delta under F ~ delta^1.5
    path, tip = np.array([(0.0, 0, 0, 0, 0, LIGHT), (1.0, 0, 0, 0, 0, 4 * LIGHT)]), 5e-4
    scene = replace(needle(), loads=(MovingLoad(0, path),) if point else ())
    scene = scene if point else replace(scene, contacts=(MovingContact(0, Indenter("sphere", tip), path),))
    field = scene.skin.field(0, np.array([0.0, 1.0]))
    deep = (0.75 * LIGHT / field.medium.contact_modulus / tip**0.5) ** (2 / 3) * np.array([1, 4 ** (2 / 3)])
    assert grown(field, [(1e-6, tip), (2e-6, tip)]) == pytest.approx((1 + 3e-6 / deep) ** 1.5)
    readings = np.abs(field.values).max(axis=(1, 2, 3))
    more = ((1 + 3e-6 / deep) ** 1.5 - (1 + 2e-6 / deep) ** 1.5) * readings
    assert raised(field, [(1e-6, tip)], [(2e-6, tip)]) == pytest.approx(more.max())
    assert raised(field, [(0.0, tip)], [(2e-6, tip)]) == 0
    assert pressed_by(LIGHT, field.medium, [(3e-6, tip)]) == pytest.approx(LIGHT * (1 + 3e-6 / deep[0]) ** 1.5)
