"""Every effect: nothing at strength zero, its declared statistics, the same however the frames are cut."""

import dataclasses
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.errors import InputError
from tactile.elastic.discs import disc_load
from tactile.elastic.halfspace import point_load, point_load_strain
from tactile.elastic.layer_loads import layer_load
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import ROUND_TIP, hertz_indentation, round_tip_radius
from tactile.frame import TaxelArray
from tactile.simulator.batch import Batch
from tactile.simulator.contacts import MovingLoad
from tactile.simulator.effects import ORDER, effect_class, read_effect, without
from tactile.simulator.effects.crosstalk import Crosstalk
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.frame_timing import FrameTiming
from tactile.simulator.effects.hysteresis import Hysteresis
from tactile.simulator.effects.motor_noise import MotorNoise
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.strain_nonlinearity import StrainNonlinearity, stretch
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tactile.simulator.field import Field, field_of
from tactile.simulator.roads import DIRECT
from tactile.simulator.scene import Scene

ARRAY = TaxelArray("a", 3, 4, 3e-4, 2e-4)
FULL = 0.1


def batches(values: NDArray[np.float64], t: Any, cut: int = 10**9) -> Iterator[Batch]:
    """Frames of values (n, rows, cols, 3) at the times, in pieces."""
    array = TaxelArray("a", values.shape[1], values.shape[2], 3e-4, 2e-4)
    for start in range(0, len(t), cut):
        here = slice(start, min(start + cut, len(t)))
        number = np.arange(here.start, here.stop)
        yield Batch(array, 1.0, FULL, t[here], number, values[here].copy(), np.ones(values[here].shape[:3], bool))


def through(effect: Any, values: NDArray[np.float64], t: Any = None, seed: int = 1, cut: int = 10**9) -> Any:
    times = np.arange(len(values)) * 0.01 if t is None else t
    return np.concatenate([batch.values for batch in effect(batches(values, times, cut), np.random.default_rng(seed))])


def zeros(frames: int, rows: int = 1, cols: int = 1) -> NDArray[np.float64]:
    return np.zeros((frames, rows, cols, 3))


def scene(**changes: Any) -> Scene:
    path = np.array(
        [(0.0, -3e-4, 1e-4, 0.002, 0.0, 0.0), (0.5, 0, 0, 0.004, 0.001, 0.02), (1.0, 3e-4, 0, -0.003, 0, 0.01)]
    )
    return replace(Scene("s", 100.0, 1.0, 2.4e6, (ARRAY,), (MovingLoad(0, path),)), **changes)


def fields(of: Scene, cut: int = 10**9) -> Iterator[Field]:
    times = np.arange(of.samples) / of.rate
    for start in range(0, of.samples, cut):
        here = times[start : start + cut]
        yield field_of(ARRAY, of.medium(0), here, start, of.pressed(0, here), DIRECT)


def term(effect: Any, seed: int = 1, of: Scene | None = None) -> tuple[NDArray[np.float64], Field]:
    """What a field effect adds, and the field before."""
    (before,) = fields(of or scene())
    (after,) = effect(iter([before]), np.random.default_rng(seed))
    return after.values - before.values, before


@pytest.mark.parametrize("name", ORDER)
def test_strength_zero_is_the_identity(name: str) -> None:
    plain, same = scene(), scene(effects=((name, without(effect_class(name))),))
    for one, other in zip(plain.batches(0), same.batches(0), strict=True):
        assert np.array_equal(one.values, other.values)
        assert np.array_equal(one.t, other.t)
        assert np.array_equal(one.sequence, other.sequence)
    assert same.frames == plain.frames


@pytest.mark.parametrize("name", ORDER)
@pytest.mark.parametrize("quantity", ("strain", "stress"))
def test_effects_do_something_and_do_not_care_how_frames_are_cut(
    name: str, quantity: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect: Any = effect_class(name)()
    if name == "dead_taxels":
        effect = DeadTaxels(0.3, 0.3)
    if name == "frame_timing":
        effect = FrameTiming(1e-3, 0.2, 0.2)
    touched = scene(effects=((name, effect),), arrays=(replace(ARRAY, quantity=quantity),))
    whole = list(touched)
    monkeypatch.setattr("tactile.simulator.scene.CHUNK", 7)
    pieces = list(touched)
    assert [frame.t for frame in whole] == [frame.t for frame in pieces]
    assert [frame.sequence for frame in whole] == [frame.sequence for frame in pieces]
    ones, others = (np.stack([frame.values for frame in frames]) for frames in (whole, pieces))
    assert np.isfinite(ones).all()
    assert np.abs(ones - others).max() < 1e-12 * np.abs(ones).max()
    plain = np.stack([frame.values for frame in scene(arrays=touched.arrays)])
    changed = ones.shape != plain.shape or not np.array_equal(ones, plain)
    assert changed != (name == "poisson_ratio" and quantity == "stress")  # stress does not depend on nu


@pytest.mark.parametrize("name", ORDER)
def test_every_effect_says_what_it_is(name: str) -> None:
    kind: Any = effect_class(name)
    assert kind.STAGE in ("field", "frames")
    assert set(kind.NONE) <= {field.name for field in dataclasses.fields(kind)}
    assert {attribute for attribute, _ in kind.KEYS.values()} == {field.name for field in dataclasses.fields(kind)}
    assert kind.__doc__
    # an effect that draws no numbers gives the same whatever the generator
    one, other = (list(scene(effects=((name, kind()),), seed=seed)) for seed in (0, 5))
    same = len(one) == len(other) and all(np.array_equal(a.values, b.values) for a, b in zip(one, other, strict=True))
    assert same or kind.RANDOM


def test_poisson_ratio_is_the_half_space_at_that_ratio() -> None:
    added, before = term(PoissonRatio(0.4))
    loads = before.pressed.loads[:, None, None]
    wanted = point_load_strain(ARRAY.positions(), ARRAY.depth, loads, 2.4e6, 0.4)
    assert np.abs(before.values + added - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_finite_tip_is_the_round_tip() -> None:
    added, before = term(FiniteTip(30e-6))
    loads = before.pressed.loads[:, None, None]
    radii = round_tip_radius(loads[..., 4], 30e-6, Medium(2.4e6).contact_modulus)
    wanted = disc_load(ARRAY.positions(), ARRAY.depth, loads, radii, ROUND_TIP, Medium(2.4e6), radii / 30e-6)
    assert np.abs(before.values + added - wanted).max() < 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize("thickness", (2e-4, 3e-4, 4e-3))
def test_finite_thickness_is_the_layer(thickness: float) -> None:
    added, before = term(FiniteThickness(thickness))
    wanted = layer_load(ARRAY.positions(), ARRAY.depth, before.pressed.loads[:, None, None], thickness, Medium(2.4e6))
    assert np.abs(before.values + added - wanted).max() < 1e-12 * np.abs(before.values).max()
    if thickness == ARRAY.depth:
        assert np.abs(wanted[..., 2]).max() < 1e-6 * np.abs(before.values).max()  # on the base nothing is squeezed


def test_taxel_area_is_the_mean_over_the_area() -> None:
    added, before = term(TaxelArea(150e-6))
    steps = (np.arange(60) + 0.5) / 60 * 150e-6 - 75e-6
    nodes = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    at = ARRAY.positions()[:, :, None] + nodes
    frame = 50
    wanted = point_load(at, ARRAY.depth, before.pressed.loads[frame], Medium(2.4e6)).mean(axis=2)
    assert np.abs(before.values[frame] + added[frame] - wanted).max() < 2e-4 * np.abs(wanted).max()
    narrow = [np.abs(term(TaxelArea(width))[0]).max() for width in (20e-6, 10e-6)]
    assert narrow[0] / narrow[1] == pytest.approx(4, rel=0.02)  # second order in the width


def test_needle_vibration_moves_and_presses() -> None:
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 1e-4, 0, 0, 0, 0.02)])),), duration=40.0)
    effect = NeedleVibration(lateral=2e-6, vertical=1e-6, tip_radius=50e-6)
    (before,) = fields(still)
    (after,) = effect(iter([before]), np.random.default_rng(3))
    moved = after.pressed.totals[:, 0] - before.pressed.totals[:, 0]
    assert moved[:, :2].std(axis=0) == pytest.approx((2e-6, 2e-6), rel=0.05)
    assert np.abs(moved[:, :2].mean(axis=0)).max() < 1e-7
    depth = hertz_indentation(0.02, 50e-6, Medium(2.4e6).contact_modulus)
    assert moved[:, 4].std() == pytest.approx(0.02 * 1.5 * 1e-6 / depth, rel=0.05)  # to first order
    assert np.corrcoef(moved[1:, 4], moved[:-1, 4])[0, 1] == pytest.approx(0, abs=0.06)
    wanted = point_load_strain(ARRAY.positions(), ARRAY.depth, after.pressed.loads[:, None, None], 2.4e6)
    assert np.abs(after.values - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_a_held_needle_can_leave_the_surface_and_no_force_stays_none() -> None:
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 0, 0, 0, 0, 1e-9)])),))
    (after,) = NeedleVibration(0.0, 1e-6)(fields(still), np.random.default_rng(3))
    forces = after.pressed.totals[:, 0, 4]
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
        forces.append(after.pressed.totals[:, 0, 4])
    height = ((np.array(forces) / 0.02) ** (2 / 3) - 1) * depth
    assert height.std() == pytest.approx(1e-7, rel=0.1)
    assert abs(height.mean()) < 2e-8
    still = scene(loads=(MovingLoad(0, np.array([(0.0, 1e-4, 0, 0, 0, 0.02)])),))
    (after,) = effect(fields(still), np.random.default_rng(0))
    assert np.ptp(after.pressed.totals[:, 0, 4]) == 0  # who stands still feels no hills


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


def test_crosstalk_mixes_channels_and_neighbours() -> None:
    values = zeros(1, 3, 3)
    values[0, 1, 1] = (1.0, 0.0, 2.0)
    out = through(Crosstalk(0.1, 0.0), values)
    assert out[0, 1, 1] == pytest.approx((1.2, 0.3, 2.1))
    assert np.count_nonzero(out.any(axis=-1)) == 1
    out = through(Crosstalk(0.0, 0.1), values)
    plane = out[0, :, :, 2] / 2
    assert plane.tolist() == [[0, 0.1, 0], [0.1, 1, 0.1], [0, 0.1, 0]]


def test_motor_noise_has_its_power_tone_and_bursts() -> None:
    effect, t = MotorNoise(0.02, 130.0, 0.3, 0.05), np.arange(400_000) * 1e-3
    out = through(effect, zeros(len(t)), t)[:, 0, 0, 0] / FULL
    assert abs(out.mean()) < 2e-4
    assert (out**2).mean() == pytest.approx(0.02**2 * 0.3 / 2, rel=0.05)
    on = np.abs(np.convolve(out**2, np.ones(9), "same")) > 0
    assert on.mean() == pytest.approx(0.3 + 8e-3 / (0.05 / 0.3), rel=0.1)
    power = np.abs(np.fft.rfft(out)) ** 2
    assert np.fft.rfftfreq(len(t), 1e-3)[power.argmax()] == pytest.approx(130.0, abs=1.0)
    always = through(MotorNoise(0.02, 130.0, 1.0, 0.05), zeros(1000), t[:1000])[:, 0, 0]
    assert (always**2).mean() == pytest.approx((0.02 * FULL) ** 2 / 2, rel=0.01)
    assert np.array_equal(always[:, 0], always[:, 2])


def test_drift_has_its_variance_at_any_interval() -> None:
    effect = Drift(0.01, 0.02)
    for steps in (4, 64):
        t = np.linspace(0, 4.0, steps + 1)
        out = through(effect, zeros(steps + 1, 60, 60), t) / FULL
        assert not out[0].any()
        for k in (steps // 4, steps):
            wanted = 0.01**2 * t[k] ** 2 + 0.02**2 * t[k]
            assert out[k].var() == pytest.approx(wanted, rel=0.05)
            assert abs(out[k].mean()) < 4 * np.sqrt(wanted / 10_800)


def test_read_noise_is_white_and_normal() -> None:
    out = through(ReadNoise(0.01), zeros(40_000, 2, 2)) / (0.01 * FULL)
    flat = np.sort(out.ravel())
    from math import erf

    normal = 0.5 * (1 + np.vectorize(erf)(flat[::97] / np.sqrt(2)))
    share = (np.arange(len(flat)) + 0.5)[::97] / len(flat)
    assert np.abs(normal - share).max() < 2 / np.sqrt(len(flat))  # Kolmogorov's test at 1e-3
    assert out.var() == pytest.approx(1, abs=0.01)
    assert (out**4).mean() == pytest.approx(3, abs=0.05)
    for lag in (1, 2, 12, 24):
        a = out.ravel()
        assert abs((a[lag:] * a[:-lag]).mean()) < 4.5 / np.sqrt(len(a))
        assert abs(((a[lag:] ** 2 - 1) * (a[:-lag] ** 2 - 1)).mean()) < 9 / np.sqrt(len(a))
    other = through(ReadNoise(0.01), zeros(40_000, 2, 2), seed=2) / (0.01 * FULL)
    assert abs((out * other).mean()) < 4.5 / np.sqrt(out.size)


def test_dead_and_stuck_taxels_are_as_many_as_declared_and_stay_so() -> None:
    values = np.ones((5, 100, 100, 3))
    out = through(DeadTaxels(0.1, 0.2), values)
    assert np.array_equal(out[0], out[4])
    dead, alive = (out[0] == 0).all(axis=-1), (out[0] == 1).all(axis=-1)
    assert dead.mean() == pytest.approx(0.1, abs=0.015)
    assert (~dead & ~alive).mean() == pytest.approx(0.2, abs=0.02)
    stuck = out[0][~dead & ~alive]
    assert np.abs(stuck).max() <= FULL
    assert stuck.std() == pytest.approx(FULL / np.sqrt(3), rel=0.05)


def test_quantisation_steps_and_saturates() -> None:
    step = 2 * 1.5 * FULL / 2**8
    values = np.linspace(-0.5, 0.5, 30_000).reshape(-1, 1, 1, 3)
    out = through(Quantisation(8, 1.5), values)
    assert np.unique(np.rint(out / step)).size == 256
    assert out.min() == pytest.approx(-128 * step)
    assert out.max() == pytest.approx(127 * step)
    inside = np.abs(values) < 127 * step
    error = (out - values)[inside]
    assert np.abs(error).max() <= step / 2 * (1 + 1e-9)
    assert (error**2).mean() == pytest.approx(step**2 / 12, rel=0.01)


def test_frame_timing() -> None:
    count = 50_000
    values = np.arange(count, dtype=float).repeat(3).reshape(-1, 1, 1, 3)
    t = np.arange(count) * 0.01
    pieces = list(FrameTiming(1e-3, 0.05, 0.02)(batches(values, t, 1000), np.random.default_rng(1)))
    time, sequence, got = (
        np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("t", "sequence", "values")
    )
    assert len(time) == pytest.approx(count * 0.98, rel=0.005)
    assert (np.diff(time) >= 0).all()
    assert np.array_equal(got[:, 0, 0, 0], sequence)  # a repeated frame is the old one altogether
    fresh = np.diff(sequence, prepend=-1) > 0
    assert 1 - fresh.mean() == pytest.approx(0.05 * 0.98, rel=0.1)
    late = (time - t[sequence])[fresh]
    late = late[np.abs(late) < 5e-3]  # a repeat whose original was lost is a frame late
    assert late.std() == pytest.approx(1e-3, rel=0.03)
    assert scene(effects=(("frame_timing", FrameTiming()),)).frames is None
    assert scene(effects=(("frame_timing", FrameTiming(drops=0.0)),)).frames == 100


def test_effects_read_their_tables() -> None:
    tip: Any = read_effect("finite_tip", {"radius_um": 20}, "here")
    assert tip.radius == pytest.approx(20e-6)
    assert read_effect("viscoelastic", {"parts": [[0.1, 2]], "creep": True}, "here") == Viscoelastic(
        ((0.1, 2.0),), True
    )
    assert read_effect("finite_thickness", {"thickness_mm": 0.5}, "here") == FiniteThickness(0.5e-3)
    assert read_effect("quantisation", {"bits": 10}, "here") == Quantisation(10)
    wrong: tuple[tuple[str, dict[str, Any], str], ...] = (
        ("read_nose", {}, "unknown key 'read_nose'; did you mean 'read_noise'"),
        ("read_noise", {"rsm": 0.1}, "here: unknown key 'rsm'; did you mean 'rms'"),
        ("read_noise", {"rms": -0.1}, "here: rms = -0.1, at least 0 wanted"),
        ("quantisation", {"bits": 1.5}, "bits = 1.5, a whole number"),
        ("quantisation", {"bits": 60}, "from 0 to 48"),
        ("poisson_ratio", {"nu": 0.7}, "nu = 0.7, from 0 to 0.5"),
        ("finite_thickness", {"thickness_mm": 0}, "thickness = 0.0"),
        ("viscoelastic", {"parts": [[1, 2, 3]]}, "pairs wanted"),
        ("dead_taxels", {"dead": 0.7, "stuck": 0.7}, "stuck = 0.7"),
    )
    for name, given, message in wrong:
        with pytest.raises(InputError, match=message):
            read_effect(name, given, "here")
    with pytest.raises(InputError, match="thickness of at least the depth"):
        list(scene(effects=(("finite_thickness", FiniteThickness(1e-4)),)))
