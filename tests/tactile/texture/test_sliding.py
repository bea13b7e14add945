"""Friction and roughness of the located load on textures of a scene."""

from pathlib import Path

import numpy as np
import pytest

from tactile.output.collected import Collected
from tactile.pipeline import run
from tactile.settings import Settings
from tactile.sources import open_source

TEXT = """
title = "one material"
rate_hz = 66.7
duration_s = 3.0
[cover]
youngs_modulus_mpa = 0.87
[[finger]]
name = "tip"
rows = 2
cols = 2
pitch_mm = 1.5
depth_mm = 1.5
[[texture]]
finger = "tip"
material = "{material}"
speed_mm_s = 5
direction_deg = 20
force_N = 0.3
stiffness_N_mm = 1.0
start_s = 0.2
stop_s = 2.9
"""


@pytest.mark.parametrize(("material", "friction", "rougher"), [("rasp", 0.86, 12), ("smooth wood", 0.53, 2)])
def test_friction_and_roughness_of_materials(tmp_path: Path, material: str, friction: float, rougher: float) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(TEXT.format(material=material), encoding="utf-8")
    seen = Collected()
    run(open_source(path), Settings(), [seen])
    columns = seen.columns("tip")
    assert np.nanmedian(columns.friction) == pytest.approx(friction, abs=0.04)
    assert rougher < np.nanmedian(columns.roughness) < 2.5 * rougher
