"""Gains and cross-axis matrices of every taxel from known loads, through the file and the command line."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.calibration.file import load_calibration
from tactile.calibration.from_weights import KnownLoads, Model, calibrate_loads
from tactile.calibration.taxel_file import write_taxel_gains
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.core.source import FrameStream
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.settings import Settings
from tactile.sources.replay_npz import write_npz
from tests.kits.serial import call

PAD = TaxelArray("pad", 2, 2, 4e-3, 0.0, quantity="force")
SKIN = TaxelArray("skin", 2, 2, 1.5e-3, 1.5e-3)
MODULUS = 2.4e6


def sensor(random: np.random.Generator, cross: float = 0.1) -> Floats:
    """Return matrices (2, 2, 3, 3) from readings to force, with different gains and cross-talk."""
    own = np.eye(3) * random.uniform(0.7, 1.4, (2, 2, 3, 1)) * [2e-3, 2e-3, 5e-3]
    return np.asarray(own + random.normal(size=(2, 2, 3, 3)) * cross * 2e-3)


def pressed(random: np.random.Generator, matrix: Floats, count: int, noise: float = 0.0) -> tuple[Floats, Floats]:
    """Return readings (count, 2, 2, 3) of weights at random places, and their forces (count, 3)."""
    forces = np.column_stack([random.normal(size=(count, 2)) * 0.4, random.uniform(0.5, 3, count)])
    share = random.dirichlet(np.ones(4), count).reshape(count, 2, 2, 1)
    mine = share * forces[:, None, None] + random.normal(size=(count, 2, 2, 3)) * 0.1 * (share - 0.25)
    mine += (forces[:, None, None] - mine.sum(axis=(1, 2), keepdims=True)) / 4  # the pad bears the whole load
    readings = np.linalg.solve(matrix, mine[..., None])[..., 0]
    return readings + random.normal(size=readings.shape) * noise, forces


def test_weights_give_the_matrices_of_a_force_pad() -> None:
    random = np.random.default_rng(1)
    matrix = sensor(random)
    readings, forces = pressed(random, matrix, 40)
    made = calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "matrix")
    np.testing.assert_allclose(made.matrix, matrix, rtol=1e-8, atol=1e-11)
    np.testing.assert_allclose(made(readings).sum(axis=(1, 2)), forces, atol=1e-10)


def test_deviations_are_those_of_the_errors() -> None:
    random = np.random.default_rng(2)
    matrix, off = sensor(random), []
    for _ in range(30):
        readings, forces = pressed(random, matrix, 60)
        forces = forces + random.normal(size=forces.shape) * 0.01
        made = calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "matrix")
        off.append((made.matrix - matrix) / made.sigma)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(1, abs=0.1)


def test_simpler_models_need_fewer_loads() -> None:
    random = np.random.default_rng(3)
    matrix = sensor(random, cross=0.0)
    readings, forces = pressed(random, matrix, 6)
    made = calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "gains")
    np.testing.assert_allclose(made.matrix, matrix, rtol=1e-8, atol=1e-12)
    with pytest.raises(InputError, match="6 loads for 12 coefficients; at least 13 wanted"):
        calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "matrix")
    same = np.broadcast_to(sensor(random)[0, 0], (2, 2, 3, 3))
    readings, forces = pressed(random, same, 6)
    made = calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "common")
    np.testing.assert_allclose(made.matrix, same, rtol=1e-8, atol=1e-12)


def test_undetermined_gains_are_refused() -> None:
    random = np.random.default_rng(4)
    matrix = sensor(random)
    readings, _ = pressed(random, matrix, 40)
    readings[:, 1, 0] = 0  # never loaded
    forces = (matrix @ readings[..., None])[..., 0].sum(axis=(1, 2)) + random.normal(size=(40, 3)) * 0.01
    readings[:, 1, 0] = random.normal(size=(40, 3))
    with pytest.raises(InputError, match=r"taxel \(1, 0\): . gain .*loads on it along"):
        calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "matrix")
    readings[:, 1, 0] = 0
    with pytest.raises(InputError, match="determine 9 of 12 coefficients"):
        calibrate_loads(readings, KnownLoads(forces, None), PAD, None, "matrix")


@pytest.mark.parametrize("model", ["gains", "matrix", "common"])
@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_loads_at_known_places_give_the_gains_with_and_without_noise(quantity: Quantity, model: Model) -> None:
    """A fit of the signals to the noisy readings would reduce them by more than 1 %."""
    random, skin = np.random.default_rng(8), replace(SKIN, quantity=quantity)
    true = np.diag([1.8, 1.8, 1.25]) + (0.0 if model == "gains" else random.normal(size=(3, 3)) * 0.1)
    off, own = [], []
    field = point_load_strain if quantity == "strain" else point_load_stress
    more = (MODULUS,) if quantity == "strain" else ()
    loads = np.column_stack([random.uniform(-1e-3, 1e-3, (60, 2)), random.normal(size=(60, 3)) * 0.2 + [0, 0, 0.7]])
    signals = np.array([field(skin.positions(), skin.depth, [load], *more) for load in loads])
    readings = np.linalg.solve(true, signals[..., None])[..., 0]
    known = KnownLoads(loads[:, 2:], loads[:, :2])
    exact = calibrate_loads(readings, known, skin, MODULUS, model)
    np.testing.assert_allclose(exact.matrix, np.broadcast_to(true, (2, 2, 3, 3)), rtol=1e-8, atol=1e-11)
    with pytest.raises(InputError, match="x and y wanted"):
        calibrate_loads(readings, known._replace(places=None), skin, MODULUS, model)
    for _ in range(40):
        noisy = readings + random.normal(size=readings.shape) * 0.02 * np.abs(readings).max()
        made = calibrate_loads(noisy, known, skin, MODULUS, model)
        off.append((made.matrix - true)[..., [0, 1, 2], [0, 1, 2]] / np.diag(true))
        own.append(made.sigma[..., [0, 1, 2], [0, 1, 2]] / np.diag(true))
    bias, scatter = np.mean(off, axis=(0, 1, 2)), np.std(off, axis=0)
    assert (np.abs(bias) < 0.002 + 2 * scatter.mean(axis=(0, 1)) / np.sqrt(40)).all()
    assert np.sqrt(np.mean(np.square(own)) / np.mean(scatter**2)) == pytest.approx(1, abs=0.15)


def recorded(folder: Path, matrix: Floats) -> tuple[Path, Path]:
    """Write a recording of weights on the pad after a second without load, and the table of their times."""
    random = np.random.default_rng(6)
    readings, forces = pressed(random, matrix, 30)
    frames, table = [], ["from_s,to_s,q_n,r_n,grams"]
    offset = random.normal(size=(2, 2, 3)) * 20
    for n in range(100 + 30 * 20):
        at = (n - 100) // 20
        values = (readings[at] if n >= 100 else np.zeros((2, 2, 3))) + offset + random.normal(size=(2, 2, 3)) * 0.05
        frames.append(Frame(0, n / 100, n, values, np.ones((2, 2), bool)))
    for at, force in enumerate(forces):
        start = 1 + 0.2 * at
        table.append(f"{start + 0.02:.3f},{start + 0.18:.3f},{force[0]},{force[1]},{force[2] / 9.80665e-3}")
    write_npz(folder / "pad.npz", FrameStream("pad", (PAD,), None, len(frames), frames))
    (folder / "weights.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    return folder / "pad.npz", folder / "weights.csv"


def test_weights_through_the_command_line(tmp_path: Path) -> None:
    matrix = sensor(np.random.default_rng(7))
    scan, weights = recorded(tmp_path, matrix)
    done = call("calibrate", scan, "--weights", weights, "--tare", 100, "-o", tmp_path / "pad.toml")
    assert done.exit_code == 0, done.output
    assert "30 loads, 2 x 2 taxels of force" in done.stdout
    made = load_calibration(tmp_path / "pad.toml")
    assert isinstance(made, TaxelGains)
    assert (np.abs(made.matrix - matrix) < 5 * made.sigma + 1e-12).all()
    printed = json.loads(call("calibrate", scan, "--weights", weights, "--tare", 100, "--json").stdout)
    np.testing.assert_allclose(printed["matrix"], made.matrix)
    np.testing.assert_allclose(printed["sigma"], made.sigma)
    run: Any = call("run", scan, "--calibration", tmp_path / "pad.toml", "--tare", 100, "-o", tmp_path / "out")
    assert run.exit_code == 0, run.output
    table: Any = np.genfromtxt(tmp_path / "out" / "frames.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    loads = np.genfromtxt(weights, delimiter=",", names=True)
    for one in loads[:5]:
        during = (table["t_s"] > one["from_s"]) & (table["t_s"] < one["to_s"])
        assert table["load_f_n"][during].mean() == pytest.approx(one["grams"] * 9.80665e-3, rel=5e-3)
        assert table["load_q_n"][during].mean() == pytest.approx(one["q_n"], abs=5e-3)
    live = Settings().calibrated(made, (PAD,))
    assert live.gains is made
    with pytest.raises(InputError, match=r"2 x 2 taxels of force for taxel array 'skin'"):
        Settings().calibrated(made, (SKIN,))


def test_wrong_tables_are_refused_in_one_line(tmp_path: Path) -> None:
    scan, weights = recorded(tmp_path, sensor(np.random.default_rng(7)))
    text = weights.read_text(encoding="utf-8")
    for changed, message in (
        (text.replace("grams", "pounds"), "one of grams and f_n"),
        (text.replace("\n1.020,", "\none,"), "line 2: from_s 'one', a number wanted"),
        (text.replace("\n1.020,1.180", "\n1.020,0.9"), "an end after its start wanted"),
        (text.replace("\n1.020,1.180", "\n1.020,1.380"), "a constant load wanted"),
        (text.replace("\n1.020,1.180", "\n91.020,91.180"), "0 frames, at least 2"),
        ("from_s,to_s,grams\n", "0 loads"),
    ):
        weights.write_text(changed, encoding="utf-8")
        refused = call("calibrate", scan, "--weights", weights, "--tare", 100)
        assert refused.exit_code == 2
        assert message in refused.output
    assert call("calibrate", scan).exit_code == 2
    assert call("calibrate", scan, "--weights", weights, "--load-n", 1).exit_code == 2


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("rows = 2", "rows = 3", "4 \\[\\[taxel\\]\\] of 3 x 2"),
        ("at = [0, 1]", "at = [0, 0]", "that is not there before"),
        ("quantity = ", "quantities = ", "quantit"),
        ('"force"', '"weight"', "one of strain, stress, force"),
        ("matrix = [[", "matrix = [[1], [", "three rows of three numbers"),
    ],
)
def test_files_of_taxel_gains_are_checked(old: str, new: str, match: str, tmp_path: Path) -> None:
    made = TaxelGains(np.broadcast_to(np.eye(3), (2, 2, 3, 3)), np.zeros((2, 2, 3, 3)), "force")
    path = tmp_path / "pad.toml"
    write_taxel_gains(path, made)
    again = load_calibration(path)
    assert isinstance(again, TaxelGains)
    np.testing.assert_array_equal(again.matrix, made.matrix)
    path.write_text(path.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=match):
        load_calibration(path)
