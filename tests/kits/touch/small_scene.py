"""A small scene as tables; a load, a sphere and a texture for it; the values of its frames."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from tactile.simulator.scene_file.file import scene_from

SCENE = """
title = "t"
rate_hz = 100
duration_s = 0.3
[cover]
youngs_modulus_mpa = 2.4
[[finger]]
name = "left"
rows = 2
cols = 3
pitch_mm = 1.5
depth_mm = 1.5
"""
LOAD = {"finger": "left", "path": [[0.0, 0.0, 0.0, 0.1, 0.0, 1.0], [0.3, 0.4, -0.8, 0.2, 0.0, 2.0]]}
SPHERE = {"finger": "left", "shape": "sphere", "radius_mm": 3, "path": [[0.0, 0, 0, 0, 0, 0.5]]}
TEXTURE = {"finger": "left", "material": "rasp", "stop_s": 0.3, "speed_mm_s": 5, "force_N": 0.3}


def made(folder: Path = Path(), **changes: Any) -> Any:
    return scene_from({**copy.deepcopy(tomllib.loads(SCENE)), **changes}, "here", folder)


def values(scene: Any, finger: int = 0) -> Any:
    _ = scene.range_notes  # read here, so that they are no warnings: many of these scenes are weak
    return np.concatenate([batch.values for batch in scene.batches(finger)])
