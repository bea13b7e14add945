"""Simulated grasps against Cattaneo's closed form; events of some grasps; `tactile score --grasps`."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.score import partial_slip
from tactile.score.partial_slip import Grasp, grasp
from tactile.score.simulated import score_grasps
from tactile.settings import Settings
from tests.kits.serial import call
from tests.kits.touch.made import events

FINE = TaxelArray("fine", 40, 40, 0.25e-3, 0.0, quantity="force")
BALL = Grasp(
    0, FINE, 100.0, 2.0, 4e-3, (0.1e-3, -0.2e-3), 0.6, 0.3, "force", 1.0, 0.0, (0.0, 0.1, 0.2, 1.2, 1.5, 1.6, 1.7),
    (0, 0),
)  # fmt: skip


@pytest.mark.parametrize("part", [0.2, 0.5, 0.9, 0.99])
def test_forces_of_partial_slip_match_the_closed_form(part: float) -> None:
    """q = mu p0 (sqrt(1 - r^2/a^2) - c/a sqrt(1 - r^2/c^2)), c = a (1 - Q / mu P)^(1/3), at the taxels' centres."""
    t, values = BALL.forces()
    frame = values[np.searchsorted(t, 0.2 + part - 1e-9)]
    x, y = np.moveaxis(FINE.positions() - BALL.middle, -1, 0)
    r2, a = x**2 + y**2, BALL.radius
    c, p0 = a * (1 - part) ** (1 / 3), 3 * BALL.force / (2 * np.pi * a**2)
    whole, core = (np.sqrt(np.maximum(1 - r2 / size**2, 0)) for size in (a, c))
    shear, normal = BALL.friction * p0 * (whole - c / a * core), p0 * whole
    area, r = FINE.pitch**2, np.sqrt(r2)
    smooth = (abs(r - a) > FINE.pitch) & (
        abs(r - c) > FINE.pitch
    )  # elsewhere the mean over a taxel differs from its centre
    read = np.hypot(frame[..., 0], frame[..., 1])
    assert read[smooth] == pytest.approx((shear * area)[smooth], abs=0.02 * BALL.friction * p0 * area)
    assert frame[..., 2][smooth] == pytest.approx((normal * area)[smooth], abs=0.02 * p0 * area)
    assert frame[..., 2].sum() == pytest.approx(BALL.force, rel=2e-3)
    assert np.hypot(*frame[..., :2].sum(axis=(0, 1))) == pytest.approx(part * 0.6 * 2.0, rel=5e-3)


def test_full_slip_and_the_pull_of_a_constant_speed() -> None:
    t, values = BALL.forces()
    sliding = values[np.searchsorted(t, 1.3)]
    assert np.hypot(sliding[..., 0], sliding[..., 1]) == pytest.approx(0.6 * sliding[..., 2], abs=1e-12)
    soft = replace(BALL, drive="way")
    assert soft.pull(np.array([0.2, 0.7, 1.2])) == pytest.approx([0, 1 - 0.5**1.5, 1])


def test_full_slip_is_detected_and_a_pull_that_stops_before_is_not() -> None:
    kinds = {grasp(seed).drive for seed in (8, 16, 4)}
    assert kinds == {"force", "way", "held"}
    scores = score_grasps((8, 16, 4), lambda source: Settings(tare="auto"), idle_minutes=0.05)
    slip = scores.kinds["slip"]
    assert (slip.hit, slip.false, slip.missed) == (2, 0, 0)
    assert max(map(abs, slip.errors)) < 0.03
    assert all(0 <= late < 0.04 for late in scores.late)
    assert scores.before == [True, True]
    assert scores.idle == 0
    for kind in ("contact", "release"):
        assert (scores.kinds[kind].hit, scores.kinds[kind].false) == (3, 0)


def test_light_grasps_are_detected_in_noise() -> None:
    """1.1 N with an invalid taxel; the growth of the pull needs means over 20 to 40 ms, which the onset corrects."""
    scores = score_grasps((298, 311, 358), lambda source: Settings(tare="auto"))
    assert [(scores.kinds[kind].hit, scores.kinds[kind].false) for kind in ("contact", "slip", "release")] == [
        (3, 0)
    ] * 3
    assert max(map(abs, scores.kinds["slip"].errors)) < 0.03
    assert max(scores.late) > 0.05


@pytest.mark.parametrize("seed", [77006, 77057, 77075])
def test_a_held_pull_on_a_contact_little_wider_than_two_taxels_is_no_slip(seed: int) -> None:
    """The taxels with most load all have 0.7 of the friction limit; only the edge taxels show that they stick."""
    scores = score_grasps((seed,), lambda source: Settings(tare="auto"))
    assert scores.kinds["contact"].hit == 1
    assert scores.kinds["slip"].false == 0


def test_a_gradual_slip_is_not_dated_too_early() -> None:
    """Noise requires long means; at constant speed, the growth of the pull falls for 0.5 s before the slip."""
    scores = score_grasps((1057, 9112, 1018), lambda source: Settings(tare="auto"))
    assert scores.kinds["slip"].hit == 3
    assert scores.kinds["slip"].false == 0


def test_late_frames_are_no_slip() -> None:
    """Every 60th frame and those after it have times up to twelve intervals late."""
    even, interval = grasp(7).source(), 0.99 / grasp(7).rate
    late = [12 - min(n % 60, 12) for n in range(even.frames or 0)]
    frames = [replace(frame, t=frame.t + n * interval) for frame, n in zip(even, late, strict=True)]
    slips = [event.t for event in events(replace(even, stream=frames), tare="auto") if event.kind == "slip"]
    assert slips == [pytest.approx(grasp(7).truth["slip"], abs=0.03)]


def test_the_command_scores_one_half_and_names_missing_options() -> None:
    result = call("score", "--grasps", "2", "--half", "report", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["simulated"]["kinds"]["contact"]["hit"] == 1
    later = call("score", "--grasps", "1", "--from-seed", "8", "--json")
    slip = json.loads(later.stdout)["simulated"]["kinds"]["slip"]
    assert slip["onset_error_s"][1] == score_grasps((8,), lambda source: Settings(tare="auto")).kinds["slip"].errors[0]
    assert "nothing to score" in call("score").output
    assert "--array, wanted" in call("score", "--labels", "l.csv").output
    assert "--kind and --rate are of sequences" in call("score", "--grasps", "1", "--gain", "2").output


@pytest.mark.parametrize("seed", [5002, 5009])
def test_a_held_pull_on_four_taxels_is_no_slip(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(partial_slip, "NOISY", np.array(partial_slip.NOISE))
    rng, one = np.random.default_rng(seed), grasp(seed)
    pad = TaxelArray("pad", 2, 2, one.array.pitch, 0.0, quantity="force")
    radius = float(rng.uniform(0.5, 0.95)) * pad.pitch  # every taxel carries a quarter: no edge, no core
    most = float(rng.uniform(0.4, 0.75))
    held = replace(one, array=pad, radius=radius, middle=(0.0, 0.0), drive="held", most=most, noisy=(0, 0))
    kinds = {event.kind for event in events(held.source(), tare="auto")}
    assert "contact" in kinds
    assert not kinds & {"slip", "incipient_slip"}
