"""Calibration by one scan: against a sensor in closed form, and through the file."""

import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.calibration.file import Calibration, load_calibration, write_calibration
from tactile.calibration.from_scan import calibrate
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection
from tactile.calibration.sensitivity import beta_from_scan
from tactile.elastic.halfspace import point_load_strain

NOMINAL, MODULUS, LOAD, SPEED = 2e-4, 2.4e6, 0.02, 5e-4
SENSOR = Gains(1.825, 1.25)


def scan(
    depth: float = NOMINAL, turn: float = 0.0, aside: float = 0.0, half: float = 5e-4, rate: float = 50
) -> tuple[Floats, Floats]:
    """Return times and readings of a needle drawn in direction ``turn`` [rad], ``aside`` [m] of the taxel."""
    along = np.arange(-half, half + 1e-9, SPEED / rate)
    rows = np.zeros((along.size, 1, 5))
    rows[:, 0, 0] = along * np.cos(turn) - aside * np.sin(turn)
    rows[:, 0, 1] = along * np.sin(turn) + aside * np.cos(turn)
    rows[:, 0, 4] = LOAD
    strain = point_load_strain((0.0, 0.0), depth, rows, MODULUS)
    return np.arange(along.size) / rate, strain / (SENSOR.shear, SENSOR.shear, SENSOR.normal)


T, READ = scan()


@pytest.mark.parametrize("deeper", [0.85, 1.0, 1.2])
@pytest.mark.parametrize("turn", [0.0, 0.7, -2.0])
def test_a_sensor_in_closed_form_is_recovered(deeper: float, turn: float) -> None:
    made = calibrate(*scan(deeper * NOMINAL, turn), SPEED, LOAD, NOMINAL, MODULUS)
    assert made.gains.beta_ns == pytest.approx(SENSOR.beta_ns, rel=1e-6)
    assert made.depth == pytest.approx(deeper * NOMINAL, rel=1e-6)
    assert made.gains.normal == pytest.approx(SENSOR.normal, rel=1e-6)
    assert made.radial.true == pytest.approx(made.radial.found, rel=1e-5)  # no correction
    assert made.radial.force == pytest.approx(np.ones(len(made.radial.force)), rel=1e-5)
    assert made.radial.true[-1] > NOMINAL


def test_a_sensor_that_reads_pressure_as_positive_gets_a_negative_gain() -> None:
    made = calibrate(T, READ * (1, 1, -1), SPEED, LOAD, NOMINAL, MODULUS)
    assert made.gains.normal == pytest.approx(-SENSOR.normal, rel=1e-6)
    assert made.gains.shear == pytest.approx(SENSOR.shear, rel=1e-6)


def test_a_scan_within_a_tenth_of_a_depth_of_the_taxel_calibrates() -> None:
    """Eq. (18) holds for the line over the taxel; the shear across the scan gives the distance from it."""
    made = calibrate(*scan(turn=0.4, aside=1.5e-5), SPEED, LOAD, NOMINAL, MODULUS)
    assert made.gains.beta_ns == pytest.approx(SENSOR.beta_ns, rel=1e-6)
    assert made.gains.normal == pytest.approx(SENSOR.normal, rel=1e-6)
    assert made.depth == pytest.approx(NOMINAL, rel=1e-6)


@pytest.mark.parametrize(
    ("t", "readings", "match"),
    [
        (np.zeros_like(T), READ, "do not grow"),
        (*scan(half=1.1e-4), "beyond every extremum"),  # too short
        (T[::20], READ[::20], "6 samples, at least 11 wanted"),
        (*scan(aside=5e-5), "passes 50 um next to the taxel, at most 20 um"),
        (T, np.zeros_like(READ), "no signal"),
        (T, np.full_like(READ, np.nan), "not finite"),
        (T[1:], READ, r"\(100,\).*\(101, 3\)"),
        *(
            (T, np.random.default_rng(seed).normal(0, 1e-3, READ.shape), "wanted|noise|must go on") for seed in range(5)
        ),  # noise only
    ],
)
def test_scans_that_cannot_calibrate_are_refused(t: Floats, readings: Floats, match: str) -> None:
    with pytest.raises(InputError, match=match):
        calibrate(t, readings, SPEED, LOAD, NOMINAL, MODULUS)


@pytest.mark.parametrize(
    ("level", "turn", "aside", "begin"),
    [(0.01, 0.0, 0.0, 0), (0.03, 0.7, 0.0, 0), (0.03, 0.0, 1.5e-5, 80), (0.03, -2.0, -1e-5, 0), (0.05, 0.0, 0.0, 0)],
)
def test_noisy_scans_calibrate_without_bias_and_with_the_right_deviations(
    level: float, turn: float, aside: float, begin: int
) -> None:
    """Including scans next to the taxel, and ones whose start and end differ in distance from it."""
    random, found = np.random.default_rng(8), []
    t, readings = scan(turn=turn, aside=aside, rate=200)
    t, readings = t[begin:], readings[begin:]
    for _ in range(80):
        noise = random.normal(size=readings.shape) * level * np.abs(readings).max(axis=0)
        found.append(calibrate(t, readings + noise, SPEED, LOAD, NOMINAL, MODULUS))
    got = np.array([(one.gains.shear, one.gains.normal, one.depth) for one in found])
    true = np.array([SENSOR.shear, SENSOR.normal, NOMINAL])
    error, own = got / true - 1, np.array([one.sigma for one in found]) / true
    scatter = error.std(axis=0)
    assert (np.abs(error.mean(axis=0)) < 0.002 + 2 * scatter / np.sqrt(len(found))).all()
    assert (scatter < 0.35 * level).all()  # located from single readings: 1.5 times as much
    assert np.sqrt((own**2).mean(axis=0)) == pytest.approx(scatter, rel=0.25)
    # forces located from single readings are larger by 1.3 % at 3 % noise
    assert np.mean([one.radial.force[0] for one in found]) == pytest.approx(1, abs=0.002)


def test_a_slide_of_known_direction_gives_the_sign_of_the_shear() -> None:
    made = calibrate(T, READ * (-1, -1, 1), SPEED, LOAD, NOMINAL, MODULUS, toward=(1.0, 0.0))
    assert made.gains.shear == pytest.approx(-SENSOR.shear, rel=1e-6)
    with pytest.raises(InputError, match="direction"):
        calibrate(T, READ, SPEED, LOAD, NOMINAL, MODULUS, toward=(0.0, 0.0))


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("component", [0, 2])
def test_scans_that_leave_the_sensors_range_are_refused(component: int, share: float) -> None:
    t, readings = scan(turn=0.0)
    most = share * np.abs(readings[:, component]).max()
    readings[:, component] = readings[:, component].clip(-most, most)
    with pytest.raises(InputError, match=r"consecutive .* readings are .* clipped at the end"):
        calibrate(t, readings, SPEED, LOAD, NOMINAL, MODULUS)


@pytest.mark.parametrize("counts", [100, 3000])
@pytest.mark.parametrize("rate", [30, 1000])
def test_quantised_readings_are_not_refused_as_clipped(counts: int, rate: float) -> None:
    t, readings = scan(turn=0.3, rate=rate)
    count = np.abs(readings).max() / counts
    made = calibrate(t, np.round(readings / count) * count, SPEED, LOAD, NOMINAL, MODULUS)
    assert made.depth == pytest.approx(NOMINAL, rel=2 / counts)


MADE = Calibration(
    SENSOR, 2.1e-4, RadialCorrection((0.0, 9e-5, 2e-4), (0.0, 1e-4, 2.3e-4), (1.0, 1.1, 1.3)), (1e-3, 2e-3, 3e-7)
)


def test_a_calibration_file_round_trips(tmp_path: Path) -> None:
    write_calibration(tmp_path / "skin.toml", MADE)
    back: Any = load_calibration(tmp_path / "skin.toml")
    assert back.gains == SENSOR
    assert back.depth == pytest.approx(MADE.depth, rel=1e-15)
    assert back.sigma == pytest.approx(MADE.sigma, rel=1e-15)
    for name in ("found", "true", "force"):
        assert getattr(back.radial, name) == pytest.approx(list(getattr(MADE.radial, name)), rel=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("depth_mm", "depth_m", "unknown key 'depth_m' (line 5); did you mean 'depth_mm'"),
        ("depth_mm = 0.21", "depth_mm = -1.0 #", "depth_mm = -1.0, a positive"),
        ("shear_gain = 1.825", "shear_gain = 0", "shear gain 0.0"),
        ("shear_gain = 1.825\n", "", "no 'shear_gain'"),
        ("true_um = [0.0,", "true_um = [0.0, 0.0,", "true_um"),
        ("true_um = [0.0,", "true_um = [1.0,", "growing ones from 0"),
        ("[radial]", "[radial", "not TOML"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, old: str, new: str, match: str) -> None:
    path = tmp_path / "skin.toml"
    write_calibration(path, MADE)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_calibration(path)
    assert match in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_long_scan_is_interrupted_within_a_second() -> None:
    """Signals are handled at least once a second with 40 000 frames, as Ctrl-C needs."""
    handled = [time.monotonic()]
    _, readings = scan(rate=40_000 / 2)
    readings = readings + np.random.default_rng(1).normal(size=readings.shape) * 1e-2 * np.abs(readings).max()
    before = signal.signal(signal.SIGALRM, lambda *_: handled.append(time.monotonic()))
    signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
    try:
        beta = beta_from_scan(readings[:, 0], readings[:, 2])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    handled.append(time.monotonic())
    assert readings.shape == (40_001, 3)
    assert beta.beta == pytest.approx(SENSOR.beta_ns, rel=2e-3)
    assert max(np.diff(handled)) < 1
