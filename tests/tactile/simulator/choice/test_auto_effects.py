"""Effects chosen by their size: the tolerance is kept over the whole recording and for other seeds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.simulator.choice.auto_effects import candidates, choose
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.extremes import extremes
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER, effect_class
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.strain_nonlinearity import StrainNonlinearity
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tactile.simulator.field import Field
from tests.kits.touch.random_scenes import error, error_of_seeds, everything, needle, random_scene


def test_what_exceeds_the_tolerance_is_on_and_what_is_small_is_off() -> None:
    for rms, kept in ((0.02, True), (0.0001, False)):
        choice = choose(needle(("read_noise", ReadNoise(rms)), ("poisson_ratio", PoissonRatio(0.3))), 0.02, reused=True)
        assert [name for name, _ in choice.scene.effects] == ["poisson_ratio", "read_noise"][: 1 + kept]
        assert (choice.sizes["read_noise"] > 0.02) == kept
        assert ("read_noise" in choice.left_out) != kept
        assert choice.together == ()
        assert set(choice.left_out) | dict(choice.scene.effects).keys() == set(ORDER)
        assert choice.bound <= 0.02
    assert choose(needle(), 0.02).scene.effects == ()
    with pytest.raises(InputError, match="tolerance 0"):
        choose(needle(), 0)


def test_small_effects_that_add_up_are_not_all_left_out() -> None:
    # both take a little from the normal strain
    small = ("viscoelastic", Viscoelastic(((0.0135, 0.01),))), ("strain_nonlinearity", StrainNonlinearity(0.19))
    choice = choose(needle(*small), 0.02, reused=True)
    assert max(choice.sizes.values()) <= 0.02
    assert len(choice.together) == 1
    assert choice.bound <= 0.02


def test_undescribed_effects_count_at_their_typical_strength() -> None:
    choice = choose(needle().with_effects(()), 0.02, reused=True)
    assert choice.sizes["finite_tip"] > 0.02
    assert dict(choice.scene.effects)["finite_tip"] == FiniteTip()


@pytest.mark.parametrize("name", ORDER)
def test_every_effect_has_a_bound_and_keeps_it(name: str) -> None:
    scene = needle((name, effect_class(name)()))
    bounds = EffectBounds(scene, candidates(scene))
    size = bounds.sizes()[name]
    assert np.isfinite(size)
    measured = error_of_seeds(scene, needle(), range(12))
    assert measured <= size * (1 + 1e-9)
    assert size <= 12 * measured or name in ("dead_taxels", "frame_timing")  # which most seeds hardly see


def test_the_tolerance_is_kept_in_random_scenes_and_for_other_seeds() -> None:
    random, left_out = np.random.default_rng(2), 0
    for _ in range(5):
        scene = random_scene(random)
        choice = choose(scene, 0.02, reused=True)
        left_out += sum(name in dict(choice.scene.effects) for name in choice.sizes) < 12
        assert error_of_seeds(choice.scene, everything(scene), (scene.seed, 1001, 1002)) <= 0.02
    assert left_out >= 2


def test_a_tap_between_the_frames_of_a_sample_counts() -> None:
    path = np.array([(0.0, 0, 0, 0, 0, 1e-4), (40.0, 0, 0, 0, 0, 1e-4), (40.01, 1e-4, 0, 0, 0, 0.02),
                     (40.02, 0, 0, 0, 0, 1e-4), (90.0, 0, 0, 0, 0, 1e-4)])  # fmt: skip
    effects = ("surface_waviness", SurfaceWaviness(2e-7)), ("finite_tip", FiniteTip(1e-4))
    scene = replace(needle(*effects, duration=90.0), loads=(MovingLoad(0, path),))
    choice = choose(scene, 0.02, reused=True)
    assert "finite_tip" in dict(choice.scene.effects)
    assert error(choice.scene, everything(scene)) <= 0.02


def test_a_random_effect_is_judged_by_all_its_seeds() -> None:
    # one seed in seven loses a taxel; this one does not
    scene = needle(("dead_taxels", DeadTaxels(0.04, 0.0)), seed=2)
    assert error(scene, needle(seed=2)) == 0
    assert "dead_taxels" in dict(choose(scene, 0.02, reused=True).scene.effects)


def test_before_coarse_steps_nothing_is_left_out() -> None:
    # without the noise, small as it is, readings near the edge of a step fall on its other side
    scene = needle(("read_noise", ReadNoise(2e-4)), ("quantisation", Quantisation(4, 1.5)))
    choice = choose(scene, 0.02, reused=True)
    assert {"read_noise", "quantisation"} == dict(choice.scene.effects).keys()
    assert "read_noise" in choice.together


def test_a_converter_that_is_left_out_lets_others_be_left_out_whose_changes_its_steps_made_large() -> None:
    # alone its steps are 1.5 tolerances, so that with it on nothing before it goes; half a step is what it does itself
    small = ("strain_nonlinearity", StrainNonlinearity(0.02)), ("viscoelastic", Viscoelastic(((1e-4, 0.1),)))
    scene = needle(*small, ("quantisation", Quantisation(8, 1.5)))
    bounds = EffectBounds(scene, candidates(scene), tolerance=0.02)
    ((step, _),) = bounds.fingers[0].grains.values()
    choice = choose(scene, tolerance := step / bounds.peak / 1.5, reused=True)
    assert {"quantisation", "strain_nonlinearity", "viscoelastic"} <= choice.off
    assert error(choice.scene, everything(scene)) <= choice.bound <= tolerance


def test_what_is_large_only_beside_another_effect_is_tried_with_it() -> None:
    # at the bottom of a layer an incompressible cover has no normal strain at all
    scene = needle(("poisson_ratio", PoissonRatio(0.495)), ("finite_thickness", FiniteThickness(2.02e-4)))
    alone = EffectBounds(scene, candidates(scene), {"poisson_ratio"}).sizes()["poisson_ratio"]
    assert alone < 0.01
    choice = choose(scene, 0.05, reused=True)
    assert error(choice.scene, everything(scene)) <= 0.05


def test_extremes_reach_over_all_of_a_scene() -> None:
    scene = needle(duration=20.0)
    found = extremes(scene, 0)
    values = np.concatenate([field.values for field in scene.skin.fields(0, scene.skin.pieces(0))])
    assert found.seen.largest == np.abs(values).max()
    assert found.seen.normal == (values[..., 2].min(), values[..., 2].max())
    assert found.seen.change == np.abs(np.diff(values, axis=0)).max()
    at = np.unravel_index(np.abs(values).argmax(), values.shape)[0]
    assert at in np.rint(found.times * scene.rate)


def test_a_short_scene_is_chosen_by_bounds_and_a_long_one_by_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    computed, values = [0], vars(Field)["values"]
    bare = values.func

    def counted(field: Field) -> Any:
        computed[0] += 1
        return bare(field)

    monkeypatch.setattr(values, "func", counted)
    trials = {}
    for frames in (200, 20_000):
        scene = replace(needle(("finite_tip", FiniteTip(2e-5)), ("taxel_area", TaxelArea(3e-5))), rate=float(frames))
        computed[0] = 0
        choice = choose(scene, 0.02)
        trials[frames] = computed[0]  # the ideal field of points is computed at one go, not by this
        assert error(choice.scene, everything(scene)) <= 0.02
    assert trials[200] == 0
    assert trials[20_000] > 0
    coarse = needle(("read_noise", ReadNoise(2e-4)), ("quantisation", Quantisation(4, 1.5)))
    computed[0] = 0
    assert not choose(coarse, 0.02).tried
    assert computed[0] == 0  # forces alone tell that all stays


def test_a_run_computes_the_field_as_finely_as_the_tolerance_asks() -> None:
    area = replace(needle(("taxel_area", TaxelArea(3e-4)), ("read_noise", ReadNoise(0.02))), rate=2000.0)
    chosen = choose(area, 0.01)
    assert chosen.scene.accuracy == pytest.approx(2.5e-3)  # a quarter of what is left of the tolerance
    assert chosen.bounds.rougher(0.0065) == pytest.approx((1e-3, 0.007))
    assert chosen.bounds.rougher(0.0095) == pytest.approx((5e-4, 0.0095))
    assert chosen.off == chosen.bounds.zero
    assert 0 < error(chosen.scene, everything(area)) <= chosen.bound <= 0.01
    assert choose(area, 0.001).scene.accuracy == area.accuracy  # nothing is gained
    assert choose(replace(area, accuracy=1e-6), 0.01).scene.accuracy == 1e-6  # as the scene says
    assert choose(area, 0.01, reused=True).scene.accuracy == area.accuracy
    coarse = area.with_effects([*area.effects, ("quantisation", Quantisation(4, 1.5))])
    assert choose(coarse, 0.01).scene.accuracy == area.accuracy
