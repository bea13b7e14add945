"""Command `tactile calibrate`, and its file in a run."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cnnsim.support import Floats
from tactile.calibration.file import load_calibration
from tactile.cli.group import main

SCENE = """
title = "a needle over taxel (1, 1)"
rate_hz = 50
duration_s = 2.02
seed = 1
[cover]
youngs_modulus_mpa = 2.4
full_scale = 0.15
[[finger]]
name = "chip"
rows = 2
cols = 2
pitch_mm = 1.5
depth_mm = 0.2
[[load]]
finger = "chip"
path = [[0.0, {start}, {y}, 0, 0, 0.02], [2.01, {stop}, {y}, 0, 0, 0.02]]
[effect.finite_tip]
[effect.finite_thickness]
[effect.read_noise]
rms = 0.0005
"""


def invoke(*words: str | Path) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def located(folder: Path, *words: str | Path) -> Floats:
    """Return x, y, force and time (n, 4) of the INSIDE loads of ``tactile run``."""
    done = invoke("run", folder / "grasp.toml", "--replace", "-o", folder / "out", *words)
    assert done.exit_code == 0, done.output
    table: Any = np.genfromtxt(folder / "out" / "frames.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    inside = table[table["load_validity"] == "inside"]
    return np.stack([inside[name] for name in ("load_x_m", "load_y_m", "load_f_n", "t_s")], axis=-1)


def test_calibrate_then_run(tmp_path: Path) -> None:
    (tmp_path / "scan.toml").write_text(SCENE.format(start=0.25, stop=1.255, y=0.75), encoding="utf-8")
    (tmp_path / "grasp.toml").write_text(SCENE.format(start=0.55, stop=0.95, y=0.85), encoding="utf-8")
    scan_words = ("calibrate", tmp_path / "scan.toml", "--speed-mm-s", "0.5", "--load-n", "0.02")
    done = invoke(*scan_words, "-o", tmp_path / "skin.toml", "--json")
    assert done.exit_code == 0, done.output
    printed = json.loads(done.stdout)
    assert printed["taxel"] == [1, 1]
    assert 1.1 < printed["beta_ns"] < 1.25  # a layer of twice the depth
    made: Any = load_calibration(tmp_path / "skin.toml")
    assert printed["depth_mm"] == pytest.approx(made.depth * 1e3)
    shown = invoke(*scan_words).output
    for word in ("taxel (1, 1), 101 frames", "beta_ns 1.1", "of the nominal one", "radial correction to"):
        assert word in shown

    raw, mended = located(tmp_path), located(tmp_path, "--calibration", tmp_path / "skin.toml")
    off = []
    for found in (raw, mended):
        x = 0.55e-3 + 0.4e-3 * found[:, 3] / 2.01
        off.append((np.hypot(found[:, 0] - x, found[:, 1] - 0.85e-3).mean(), np.abs(found[:, 2] / 0.02 - 1).mean()))
    assert len(mended) > 0.9 * len(raw) > 80
    assert off[0][0] > 5e-6  # a tip; the bottom is known
    assert off[1][0] < 2e-6
    assert off[1][1] < 0.04 < off[0][1]


def test_mistakes_are_reported_without_a_traceback(tmp_path: Path) -> None:
    path = tmp_path / "scan.toml"
    path.write_text(SCENE.format(start=0.25, stop=1.255, y=0.85), encoding="utf-8")
    for words, message in (
        (("calibrate", path, "--speed-mm-s", "0.5", "--load-n", "0.02"), "next to the taxel"),
        (("calibrate", tmp_path / "no.csv", "--speed-mm-s", "1", "--load-n", "1"), "no scene or recording"),
        (
            ("calibrate", path, "--speed-mm-s", "0.5", "--load-n", "0.02", "--tare", "500"),
            "no frame with a valid taxel",
        ),
        (("run", path, "--calibration", tmp_path / "none.toml"), "no calibration"),
        (("run", path, "--calibration", path, "--gains", "1,1"), "leave out --gains"),
        (("calibrate", path, "--speed-mm-s", "-1", "--load-n", "0.02"), "speed -0.001"),
    ):
        done = invoke(*words)
        assert done.exit_code == 2
        assert message in done.output
        assert "Traceback" not in done.output
