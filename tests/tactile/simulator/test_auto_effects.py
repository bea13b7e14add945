"""effects = "auto": dropped effects and a coarser field keep the tolerance over the whole recording and other seeds."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.simulator.auto_effects import BOUNDS, EVALUATED, LONG, bounds, choose, readings
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER, effect_class
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.sizes import Sample
from tests.kits.touch.random_scenes import error, error_of_seeds, needle, random_scene, random_touch

pytestmark = pytest.mark.slow

SEEDS = (0, 1001, 1002)


@pytest.mark.parametrize("name", BOUNDS)
def test_bounds_hold_for_other_seeds_and_are_not_loose(name: str) -> None:
    effect = effect_class(name)()
    sample = Sample(needle())
    (bound,) = bounds({name: effect}, readings(needle(), sample.peak)).values()
    measured = error_of_seeds(needle((name, effect)), needle(), range(12)) * sample.peak
    assert measured <= bound * (1 + 1e-9)
    assert bound <= 12 * measured or name == "dead_taxels"  # none in most seeds


def test_the_bound_of_drift_holds_for_a_rare_seed() -> None:
    # of two thousand seeds the one with the largest drift: 5.1 standard deviations of its end
    effect, frames = Drift(0.02, 0.04), 50
    on = readings(replace(needle(), rate=10.0, duration=5.0), 1.0)
    still = needle().with_effects(())
    batch = still.batch(0, still.skin.field(0, np.arange(frames) / 10.0))
    batch = replace(batch, full_scale=on.full_scale, values=np.zeros_like(batch.values))
    (drifted,) = effect([batch], np.random.default_rng(755))
    farthest = np.abs(drifted.values).max()
    assert farthest > 5 * np.hypot(0.02 * 4.9, 0.04 * np.sqrt(4.9)) * on.full_scale
    assert farthest <= BOUNDS["drift"](effect, on) <= 1.2 * farthest


@pytest.mark.parametrize("frames", (200, 2000))
@pytest.mark.parametrize("tolerance", (0.003, 0.02, 0.1))
def test_the_tolerance_is_kept_in_random_scenes_and_for_other_seeds(frames: int, tolerance: float) -> None:
    changed = False
    for n in range(3 if frames == 200 else 2):
        random = np.random.default_rng((frames, int(tolerance * 1000), n))
        for scene in (random_scene(random), random_touch(random)):
            whole = replace(scene, rate=frames / scene.duration)
            choice = choose(whole, tolerance)
            changed |= bool(choice.left_out) or choice.scene.accuracy > whole.accuracy
            assert error_of_seeds(choice.scene, whole, SEEDS) <= tolerance
            assert choice.bound <= tolerance
            assert {name for name, _ in choice.scene.effects} | set(choice.left_out) <= dict(whole.effects).keys()
    assert changed


def test_small_effects_are_dropped_and_no_effect_is_added() -> None:
    for rms, dropped in ((0.02, False), (0.0001, True)):
        choice = choose(needle(("read_noise", ReadNoise(rms)), ("poisson_ratio", PoissonRatio(0.3))), 0.02)
        assert [name for name, _ in choice.scene.effects] == ["poisson_ratio", "read_noise"][: 2 - dropped]
        assert ("read_noise" in choice.left_out) == dropped
    assert choose(needle(), 0.02).scene.effects == ()
    with pytest.raises(InputError, match="tolerance 0"):
        choose(needle(), 0)


def test_small_effects_that_add_up_are_not_all_dropped() -> None:
    small = ("drift", Drift(0.0, 4e-4)), ("read_noise", ReadNoise(5e-4))
    choice = choose(needle(*small), 0.02)
    assert len(choice.left_out) == 1
    assert choice.bound <= 0.02


def test_the_field_takes_a_third_of_the_tolerance() -> None:
    area = needle(("taxel_area", TaxelArea(3e-4)))
    assert choose(area, 0.03).scene.accuracy == pytest.approx(0.01)
    assert 0 < error(choose(area, 0.03).scene, area) <= 0.01
    assert choose(area, 1e-4).scene.accuracy == area.accuracy
    assert choose(replace(area, accuracy=1e-6), 0.03).scene.accuracy == 1e-6  # as the scene states


def test_before_a_coarse_converter_nothing_changes() -> None:
    scene = needle(("read_noise", ReadNoise(2e-4)), ("quantisation", Quantisation(4, 1.5)))
    choice = choose(scene, 0.02)
    assert choice.left_out == {}
    assert error(choice.scene, scene) == 0


def test_effects_on_fields_are_dropped_by_evaluation_in_long_scenes() -> None:
    small = needle(("finite_tip", FiniteTip(1e-5)), ("taxel_area", TaxelArea(2e-5)))
    assert choose(small, 0.02).left_out == {}
    for choice in (choose(replace(small, rate=float(LONG)), 0.02), choose(small, 0.02, reused=True)):
        assert choice.left_out.keys() == {"finite_tip", "taxel_area"} <= set(EVALUATED)
        assert error(choice.scene, replace(small, rate=choice.scene.rate)) <= choice.bound <= 0.02


def test_a_tap_between_evenly_spread_frames_counts() -> None:
    path = np.array([(0.0, 0, 0, 0, 0, 1e-4), (40.0, 0, 0, 0, 0, 1e-4), (40.01, 1e-4, 0, 0, 0, 0.02),
                     (40.02, 0, 0, 0, 0, 1e-4), (90.0, 0, 0, 0, 0, 1e-4)])  # fmt: skip
    scene = replace(needle(("finite_tip", FiniteTip(1e-4)), duration=90.0), loads=(MovingLoad(0, path),))
    choice = choose(scene, 0.02)
    assert "finite_tip" in dict(choice.scene.effects)
    assert error(choice.scene, scene) <= 0.02


def test_every_dropped_effect_is_one_of_the_simulator() -> None:
    assert {*BOUNDS, *EVALUATED} <= set(ORDER)
