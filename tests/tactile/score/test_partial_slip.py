"""Simulated grasps against Cattaneo's closed form, point by point; events of a few; the command that scores them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.events.event import EventLog
from tactile.pipeline import run
from tactile.score import partial_slip
from tactile.score.measure import voted
from tactile.score.partial_slip import Grasp, grasp
from tactile.score.simulated import score_grasps
from tactile.settings import Settings
from tests.kits.serial import call

FINE = TaxelArray("fine", 40, 40, 0.25e-3, 0.0, quantity="force")
BALL = Grasp(
    0, FINE, 100.0, 2.0, 4e-3, (0.1e-3, -0.2e-3), 0.6, 0.3, "force", 1.0, 0.0, (0.0, 0.1, 0.2, 1.2, 1.5, 1.6, 1.7),
    (0, 0),
)  # fmt: skip


@pytest.mark.parametrize("part", [0.2, 0.5, 0.9, 0.99])
def test_forces_are_those_of_a_ball_that_slips_from_its_rim(part: float) -> None:
    """q = mu p0 (sqrt(1 - r^2/a^2) - c/a sqrt(1 - r^2/c^2)), c = a (1 - Q / mu P)^(1/3), at the taxels' centres."""
    t, values = BALL.forces()
    frame = values[np.searchsorted(t, 0.2 + part - 1e-9)]
    x, y = np.moveaxis(FINE.positions() - BALL.middle, -1, 0)
    r2, a = x**2 + y**2, BALL.radius
    c, p0 = a * (1 - part) ** (1 / 3), 3 * BALL.force / (2 * np.pi * a**2)
    whole, core = (np.sqrt(np.maximum(1 - r2 / size**2, 0)) for size in (a, c))
    shear, normal = BALL.friction * p0 * (whole - c / a * core), p0 * whole
    area, r = FINE.pitch**2, np.sqrt(r2)
    smooth = (abs(r - a) > FINE.pitch) & (abs(r - c) > FINE.pitch)  # elsewhere a mean is no middle
    read = np.hypot(frame[..., 0], frame[..., 1])
    assert read[smooth] == pytest.approx((shear * area)[smooth], abs=0.02 * BALL.friction * p0 * area)
    assert frame[..., 2][smooth] == pytest.approx((normal * area)[smooth], abs=0.02 * p0 * area)
    assert frame[..., 2].sum() == pytest.approx(BALL.force, rel=2e-3)
    assert np.hypot(*frame[..., :2].sum(axis=(0, 1))) == pytest.approx(part * 0.6 * 2.0, rel=5e-3)


@pytest.mark.parametrize("seed", [7, 8, 9303])
def test_a_pull_that_begins_is_borne_by_the_rim_of_the_contact_to_a_twentieth(seed: int) -> None:
    """At 3 % of friction a ring of a hundredth of the radius slides: a sum over few points misses it by a fifth."""
    one = grasp(seed)
    core, middle = 0.97 ** (1 / 3) * one.radius, np.array(one.middle)
    read = np.asarray(one._parts(middle, one.radius)) - 0.97 * np.asarray(one._parts(middle, core))
    rows, cols = one.array.shape
    h = one.array.pitch / 160
    x, y = ((np.arange(160 * n) + 0.5 - 80 * n) * h - m for n, m in zip((cols, rows), one.middle, strict=True))
    r2 = y[:, None] ** 2 + x**2
    p, c = (np.sqrt(np.maximum(a**2 - r2, 0)) / (2 / 3 * np.pi * one.radius**3) * h**2 for a in (one.radius, core))
    exact = (p - c).reshape(rows, 160, cols, 160).sum(axis=(1, 3))
    assert read == pytest.approx(exact, abs=0.05 * exact.max())


def test_a_ball_that_slides_carries_friction_everywhere_and_one_moved_evenly_yields_softly() -> None:
    t, values = BALL.forces()
    sliding = values[np.searchsorted(t, 1.3)]
    assert np.hypot(sliding[..., 0], sliding[..., 1]) == pytest.approx(0.6 * sliding[..., 2], abs=1e-12)
    soft = replace(BALL, drive="way")
    assert soft.pull(np.array([0.2, 0.7, 1.2])) == pytest.approx([0, 1 - 0.5**1.5, 1])


def test_slip_is_told_when_all_slides_and_not_when_a_pull_stops_before() -> None:
    kinds = {grasp(seed).drive for seed in (8, 16, 4)}
    assert kinds == {"force", "way", "held"}
    told = score_grasps((8, 16, 4), lambda source: Settings(tare="auto"), idle_minutes=0.05)
    slip = told.kinds["slip"]
    assert (slip.hit, slip.false, slip.missed) == (2, 0, 0)
    assert max(map(abs, slip.errors)) < 0.03
    assert all(0 <= late < 0.04 for late in told.late)
    assert told.before == [True, True]
    assert told.idle == 0
    for kind in ("contact", "release"):
        assert (told.kinds[kind].hit, told.kinds[kind].false) == (3, 0)


def test_light_grasps_are_told_in_spite_of_noise() -> None:
    """1.1 N, beside a taxel that is left out; growth of the pull needs means of 20 to 40 ms, which the onset knows."""
    told = score_grasps((298, 311, 358), lambda source: Settings(tare="auto"))
    assert [(told.kinds[kind].hit, told.kinds[kind].false) for kind in ("contact", "slip", "release")] == [(3, 0)] * 3
    assert max(map(abs, told.kinds["slip"].errors)) < 0.03
    assert max(told.late) > 0.05


@pytest.mark.parametrize("seed", [77006, 77057, 77075])
def test_a_pull_held_by_a_contact_little_wider_than_two_taxels_is_no_slip(seed: int) -> None:
    """Those that bear most carry 0.7 of friction all alike; that this is not all of it the edge alone says."""
    told = score_grasps((seed,), lambda source: Settings(tare="auto"))
    assert told.kinds["contact"].hit == 1
    assert told.kinds["slip"].false == 0


def test_a_slip_that_comes_by_and_by_is_not_dated_back() -> None:
    """Under noise that asks for long means; moved evenly, the pull's growth falls for half a second before."""
    told = score_grasps((1057, 9112, 1018), lambda source: Settings(tare="auto"))
    assert told.kinds["slip"].hit == 3
    assert told.kinds["slip"].false == 0


def test_frames_that_come_late_are_no_pull_that_halts() -> None:
    """Every 60th frame and those after it are stamped up to twelve intervals late; the readings are even."""
    even, interval = grasp(7).source(), 0.99 / grasp(7).rate
    late = [12 - min(n % 60, 12) for n in range(even.frames or 0)]
    frames = [replace(frame, t=frame.t + n * interval) for frame, n in zip(even, late, strict=True)]
    log = EventLog()
    uneven = replace(even, stream=frames)
    run(uneven, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    slips = [event.t for event in log.events if event.kind == "slip"]
    assert slips == [pytest.approx(grasp(7).truth["slip"], abs=0.03)]


def test_the_command_scores_one_half_and_says_what_is_missing() -> None:
    result = call("score", "--grasps", "2", "--half", "report", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["simulated"]["kinds"]["contact"]["hit"] == 1
    later = call("score", "--grasps", "1", "--from-seed", "8", "--json")
    slip = json.loads(later.stdout)["simulated"]["kinds"]["slip"]
    assert slip["onset_error_s"][1] == score_grasps((8,), lambda source: Settings(tare="auto")).kinds["slip"].errors[0]
    assert "nothing to score" in call("score").output
    assert "--array, wanted" in call("score", "--labels", "l.csv").output
    assert "--kind and --rate are of sequences" in call("score", "--grasps", "1", "--gain", "2").output


def test_a_vote_leaves_out_what_no_neighbour_says() -> None:
    plane = np.array([[1, 1, 0], [0, 0, 0], [0, 0, -1]], np.int8)
    assert np.array_equal(voted(plane), [[1, 1, 0], [0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize("seed", [5002, 5009])
def test_a_pull_held_on_four_taxels_in_a_square_is_no_slip(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(partial_slip, "NOISY", np.array(partial_slip.NOISE))
    rng, one = np.random.default_rng(seed), grasp(seed)
    pad = TaxelArray("pad", 2, 2, one.array.pitch, 0.0, quantity="force")
    radius = float(rng.uniform(0.5, 0.95)) * pad.pitch  # all four bear a quarter: no edge, no core
    most = float(rng.uniform(0.4, 0.75))
    held = replace(one, array=pad, radius=radius, middle=(0.0, 0.0), drive="held", most=most, noisy=(0, 0))
    log = EventLog()
    run(held.source(), Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    kinds = {event.kind for event in log.events}
    assert "contact" in kinds
    assert not kinds & {"slip", "incipient_slip"}
