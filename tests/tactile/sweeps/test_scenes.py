from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.simulator.scene_file.file import scene_from
from tactile.sweeps.scenes import changed_table, check, run

SCENE = """
title = "a push"
rate_hz = 50
duration_s = 0.4
[cover]
youngs_modulus_mpa = 1.0
[[finger]]
name = "pad"
rows = 4
cols = 4
pitch_mm = 1.0
depth_mm = 1.0
[[load]]
finger = "pad"
path = [[0.0, 0.2, 0.1, 0.0, 0.0, 0.0], [0.1, 0.2, 0.1, 0.0, 0.0, 0.4], [0.4, 0.2, 0.1, 0.0, 0.0, 0.4]]
[effect.read_noise]
rms = 0.001
"""


@pytest.fixture
def scene(tmp_path: Path) -> str:
    (tmp_path / "push.toml").write_text(SCENE)
    return str(tmp_path / "push.toml")


def test_what_a_case_chooses_stands_in_the_scene(scene: str) -> None:
    table, folder = changed_table({"scene": scene, "rows": 7, "seed": 5, "force": 2.0, "effects": False})
    changed = scene_from(table, scene, folder)
    assert changed.arrays[0].shape == (7, 4)
    assert changed.seed == 5
    assert changed.loads_at(0, np.array([0.4]))[0, 0, 4] == pytest.approx(0.8)
    assert not changed.effects


def test_a_case_tells_events_and_how_far_off_the_located_loads_are(scene: str) -> None:
    quiet, noisy = run([{"scene": scene, "effects": False}, {"scene": scene, "effects": {"read_noise": {"rms": 0.01}}}])
    assert quiet["events_contact"] == 1
    assert quiet["place_error_mm"] < 1e-3 < noisy["place_error_mm"]
    assert quiet["frames"] == noisy["frames"] == 20


def test_a_case_that_is_no_scene_is_refused_before_the_sweep(scene: str) -> None:
    with pytest.raises(InputError, match="rows = 0, a whole number from 1 up wanted"):
        check({"scene": scene, "rows": 0})
    with pytest.raises(InputError, match="unknown key 'reed_noise'; did you mean 'read_noise'"):
        check({"scene": scene, "effects": {"reed_noise": {"rms": 0.1}}})
