"""Effects of the body and what touches it, against closed forms."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.discs import disc_load
from tactile.elastic.halfspace import point_load, point_load_strain
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import ROUND_TIP, hertz_indentation, round_tip_radius
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.hysteresis import Hysteresis
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.strain_nonlinearity import StrainNonlinearity, stretch
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tests.kits.touch.effects import ARRAY, FULL, scene, through
from tests.oracles.elastic.layer import layer_load


def fields(of: Scene, cut: int = 10**9) -> Iterator[Field]:
    times = np.arange(of.samples) / of.rate
    return of.skin.fields(0, ((start, times[start : start + cut]) for start in range(0, of.samples, cut)))


def term(effect: Any, seed: int = 1, of: Scene | None = None) -> tuple[NDArray[np.float64], Field]:
    """What a field effect adds, and the field before."""
    (before,) = fields(of or scene(accuracy=0.0))
    (after,) = effect(iter([before]), np.random.default_rng(seed))
    return after.values - before.values, before


def test_poisson_ratio_is_the_half_space_at_that_ratio() -> None:
    added, before = term(PoissonRatio(0.4))
    loads = before.loads.points[:, None, None]
    wanted = point_load_strain(ARRAY.positions(), ARRAY.depth, loads, 2.4e6, 0.4)
    assert np.abs(before.values + added - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_finite_tip_is_the_round_tip() -> None:
    added, before = term(FiniteTip(30e-6))
    loads = before.loads.points[:, None, None]
    radii = round_tip_radius(loads[..., 4], 30e-6, Medium(2.4e6).contact_modulus)
    wanted = disc_load(ARRAY.positions(), ARRAY.depth, loads, radii, ROUND_TIP, Medium(2.4e6), radii / 30e-6)
    assert np.abs(before.values + added - wanted).max() < 1e-12 * np.abs(wanted).max()


def test_arrays_of_a_scene_know_their_covers_thickness() -> None:
    """So that loads are located as on the layer; without the effect nothing is known of one."""
    for effect, thickness in (
        (FiniteThickness(5e-4), 5e-4), (FiniteThickness(), 2 * ARRAY.depth), (FiniteThickness(np.inf), None),
    ):  # fmt: skip
        of = scene(effects=[effect])
        assert of.arrays[0].thickness == thickness
        assert replace(of, effects=()).arrays[0].thickness is None


@pytest.mark.parametrize("thickness", (2e-4, 3e-4, 4e-3))
def test_finite_thickness_is_the_layer(thickness: float) -> None:
    added, before = term(FiniteThickness(thickness))
    wanted = layer_load(ARRAY.positions(), ARRAY.depth, before.loads.points[:, None, None], thickness, Medium(2.4e6))
    assert np.abs(before.values + added - wanted).max() < 1e-7 * np.abs(wanted).max()
    if thickness == ARRAY.depth:
        assert np.abs(wanted[..., 2]).max() < 1e-6 * np.abs(before.values).max()  # on the base nothing is squeezed


def test_taxel_area_is_the_mean_over_the_area() -> None:
    added, before = term(TaxelArea(150e-6))
    steps = (np.arange(60) + 0.5) / 60 * 150e-6 - 75e-6
    nodes = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    at = ARRAY.positions()[:, :, None] + nodes
    frame = 50
    wanted = point_load(at, ARRAY.depth, before.loads.points[frame], Medium(2.4e6)).mean(axis=2)
    assert np.abs(before.values[frame] + added[frame] - wanted).max() < 2e-4 * np.abs(wanted).max()
    narrow = [np.abs(term(TaxelArea(width))[0]).max() for width in (20e-6, 10e-6)]
    assert narrow[0] / narrow[1] == pytest.approx(4, rel=0.02)  # second order in the width


def test_needle_vibration_moves_and_presses() -> None:
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 1e-4, 0, 0, 0, 0.02)])),), duration=40.0)
    effect = NeedleVibration(lateral=2e-6, vertical=1e-6, tip_radius=50e-6)
    (before,) = fields(still)
    (after,) = effect(iter([before]), np.random.default_rng(3))
    moved = after.loads.totals[:, 0] - before.loads.totals[:, 0]
    assert moved[:, :2].std(axis=0) == pytest.approx((2e-6, 2e-6), rel=0.05)
    assert np.abs(moved[:, :2].mean(axis=0)).max() < 1e-7
    depth = hertz_indentation(0.02, 50e-6, Medium(2.4e6).contact_modulus)
    assert moved[:, 4].std() == pytest.approx(0.02 * 1.5 * 1e-6 / depth, rel=0.05)  # to first order
    assert np.corrcoef(moved[1:, 4], moved[:-1, 4])[0, 1] == pytest.approx(0, abs=0.06)
    wanted = point_load_strain(ARRAY.positions(), ARRAY.depth, after.loads.points[:, None, None], 2.4e6)
    assert np.abs(after.values - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_a_held_needle_can_leave_the_surface_and_no_force_stays_none() -> None:
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 0, 0, 0, 0, 1e-9)])),))
    (after,) = NeedleVibration(0.0, 1e-6)(fields(still), np.random.default_rng(3))
    forces = after.loads.totals[:, 0, 4]
    assert forces.min() == 0
    assert np.isfinite(forces).all()
    nothing = scene(loads=(MovingLoad(0, np.array([(0.0, 0, 0, 0, 0, 0.0)])),))
    for effect in (NeedleVibration(), SurfaceWaviness()):
        (after,) = effect(fields(nothing), np.random.default_rng(3))
        assert not after.values.any()


def test_waviness_is_one_surface_of_the_declared_height() -> None:
    effect, forces = SurfaceWaviness(1e-7, 1e-3), []
    depth = hertz_indentation(0.02, 50e-6, Medium(2.4e6).contact_modulus)
    for seed in range(40):
        path = np.array([(0.0, -2e-2, 3e-2, 0, 0, 0.02), (1.0, 2e-2, 1e-2, 0, 0, 0.02)])
        (after,) = effect(fields(scene(loads=(MovingLoad(0, path),))), np.random.default_rng(seed))
        forces.append(after.loads.totals[:, 0, 4])
    height = ((np.array(forces) / 0.02) ** (2 / 3) - 1) * depth
    assert height.std() == pytest.approx(1e-7, rel=0.1)
    assert abs(height.mean()) < 2e-8
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 1e-4, 0, 0, 0, 0.02)])),))
    (after,) = effect(fields(still), np.random.default_rng(0))
    assert np.ptp(after.loads.totals[:, 0, 4]) == 0  # who stands still feels no hills


def test_neo_hookean_stretch() -> None:
    linear = np.concatenate([-(10.0 ** np.arange(6, -9, -1)), [0.0], 10.0 ** np.arange(-8, 7)])
    stretched = stretch(linear)
    assert (np.diff(stretched) > 0).all()
    assert stretched - stretched**-2 == pytest.approx(3 * linear, rel=1e-9, abs=1e-14)
    small = 1e-4
    assert stretch(np.array([small]))[0] - 1 == pytest.approx(small + small**2, rel=1e-7)
    values = np.random.default_rng(0).normal(size=(5, 2, 2, 3)) * 0.1
    out = through(StrainNonlinearity(0.5), values)
    assert np.array_equal(out[..., :2], values[..., :2])
    assert out[..., 2] == pytest.approx((values[..., 2] + stretch(values[..., 2]) - 1) / 2)


@pytest.mark.parametrize("creep", (False, True))
def test_prony_series_is_the_closed_form_at_any_interval(creep: bool) -> None:
    parts, sign = ((0.3, 0.05), (0.2, 1.0)), 1 if creep else -1
    t = np.cumsum(np.random.default_rng(2).exponential(0.03, 200)) - 1.0
    t[100:110] = t[100]  # frames at one time
    step = np.broadcast_to(1.0, (200, 1, 1, 3))
    since = t - t[0]
    closed = 1 + sign * sum(g * (1 - np.exp(-since / tau)) for g, tau in parts)
    assert through(Viscoelastic(parts, creep), step.copy(), t, cut=17)[:, 0, 0, 1] == pytest.approx(closed, rel=1e-13)
    ramp = np.repeat(since, 3).reshape(200, 1, 1, 3)
    closed = since + sign * sum(g * (since - tau * (1 - np.exp(-since / tau))) for g, tau in parts)
    assert through(Viscoelastic(parts, creep), ramp, t)[:, 0, 0, 2] == pytest.approx(closed, rel=1e-12, abs=1e-15)


def test_prony_series_at_extreme_times() -> None:
    t, step = np.array([0.0, 1e-9, 1.0, 1e9]), np.ones((4, 1, 1, 3))
    for tau in (1e-12, 1.0, 1e12):
        out = through(Viscoelastic(((0.4, tau),)), step, t)[:, 0, 0, 0]
        assert out == pytest.approx(1 - 0.4 * -np.expm1(-t / tau), rel=1e-12)
    for wrong in (((-0.1, 1.0),), ((0.6, 1.0), (0.6, 2.0)), ((0.1, 0.0),), ((0.1,),), (0.1,)):
        with pytest.raises(InputError, match="parts"):
            Viscoelastic(wrong)  # type: ignore[arg-type]  # that is the point


def test_hysteresis_is_closed_rate_independent_and_bounded() -> None:
    effect = Hysteresis(0.4, 0.5)
    turn = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, -1, 100), np.linspace(-1, 1, 100)]) * FULL
    out = through(effect, np.repeat(turn, 3).reshape(-1, 1, 1, 3))[:, 0, 0, 0]
    assert out[-1] == pytest.approx(out[49])  # the loop closes
    assert np.abs(out - turn).max() <= 0.4 * 0.5 * FULL * (1 + 1e-12)
    lag = 0.4 * 5 / 8 * 0.5 * FULL  # half the opening of the loop, once all plays are engaged
    assert (out - turn)[120:140] == pytest.approx(np.full(20, lag))
    assert (out - turn)[220:240] == pytest.approx(np.full(20, -lag))
    slow = through(effect, np.repeat(np.repeat(turn, 4), 3).reshape(-1, 1, 1, 3))[3::4, 0, 0, 0]
    assert slow == pytest.approx(out, abs=1e-15)
